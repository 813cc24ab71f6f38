// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { recall, remember } from "./memory";

/** Light for sunlight, dark for the cabin and the deep, night to keep eyes used to the dark. */
export const THEMES = ["dark", "light", "night"] as const;
export type Theme = (typeof THEMES)[number];

export class Themes {
  onChange: (theme: Theme) => void = () => undefined;

  constructor() {
    this.apply(this.current);
  }

  get current(): Theme {
    return THEMES.find((theme) => theme === recall("theme")) ?? "dark";
  }

  choose(theme: Theme): void {
    remember("theme", theme);
    this.apply(theme);
    this.onChange(theme);
  }

  private apply(theme: Theme): void {
    document.documentElement.dataset["theme"] = theme;
    const ground = getComputedStyle(document.documentElement).getPropertyValue("--ground").trim();
    document.querySelector('meta[name="theme-color"]')?.setAttribute("content", ground);
  }
}
