// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Elements made by hand: whatever comes from outside enters as text and nothing else.

export function byId(id: string): HTMLElement {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`the page has no #${id}`);
  return element;
}

/** What could turn or hide the rest of a line: control characters and overrides of the direction of text (UAX #9, 2.2). */
// eslint-disable-next-line no-control-regex
const UNSEEN = /[\0-\x08\v-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]/g;

export function plain(text: string): string {
  return text.replace(UNSEEN, "\ufffd");
}

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  className: string,
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  element.className = className;
  element.append(...children.map((child) => (typeof child === "string" ? plain(child) : child)));
  return element;
}

/** Writes only what has changed. */
export function say(element: HTMLElement, text: string): void {
  const shown = plain(text);
  if (element.textContent !== shown) element.textContent = shown;
}

const SVG = "http://www.w3.org/2000/svg";

/** Drawn in 24 x 24, lines 2 wide, round ends. */
const ICONS = {
  check: "M5 12.5l4.5 4.5L19 7.5",
  cross: "M6 6l12 12M18 6L6 18",
  warning: "M12 4L2.8 19.5h18.4zM12 10v4.5M12 17v.2",
  stop: "M8 3h8l5 5v8l-5 5H8l-5-5V8zM12 7.5v5.5M12 16.5v.2",
  info: "M12 3.5a8.5 8.5 0 1 0 0 17a8.5 8.5 0 1 0 0-17M12 11v5M12 8v.2",
  wait: "M12 3.5a8.5 8.5 0 1 0 0 17a8.5 8.5 0 1 0 0-17M12 7.5V12l3 2",
  search: "M10.5 4a6.5 6.5 0 1 0 0 13a6.5 6.5 0 1 0 0-13M15.5 15.5L20 20",
  flag: "M6 21V4h11l-2 4 2 4H6",
  scene: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9",
  map: "M4 6l5-2 6 2 5-2v14l-5 2-6-2-5 2zM9 4v14M15 6v14",
  all: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  follow: "M12 5a7 7 0 1 0 0 14a7 7 0 1 0 0-14M12 2v4M12 18v4M2 12h4M18 12h4M12 12v.1",
  closer: "M12 5v14M5 12h14",
  farther: "M5 12h14",
  layers: "M12 4l9 4.5-9 4.5-9-4.5zM3 13l9 4.5 9-4.5",
  bell: "M6 16V11a6 6 0 0 1 12 0v5l1.5 2h-15zM10 20.5h4",
  system: "M4 13h3.5l2.5-7 4 12 2.5-5H20",
  up: "M12 19V5M6 11l6-6 6 6",
  down: "M12 5v14M6 13l6 6 6-6",
  slower: "M4 16a8 8 0 0 1 16 0M12 16l-4-4",
  light: "M12 8a4 4 0 1 0 0 8a4 4 0 1 0 0-8M12 2v2M12 20v2M2 12h2M20 12h2M5 5l1.4 1.4M17.6 17.6L19 19M19 5l-1.4 1.4M6.4 17.6L5 19",
  link: "M3 9a13 13 0 0 1 18 0M6.5 12.5a8 8 0 0 1 11 0M10 16a3 3 0 0 1 4 0M12 19v.1",
  record: "M12 6a6 6 0 1 0 0 12a6 6 0 1 0 0-12M12 9.5a2.5 2.5 0 1 0 0 5a2.5 2.5 0 1 0 0-5",
  picture: "M4 5h16v14H4zM4 16l5-5 4 4 3-3 4 4M15.5 9v.1",
  hand: "M14 4l6 6-9 9H5v-6zM12 6l6 6",
  menu: "M4 7h16M4 12h16M4 17h16",
  top: "M4 20h16M12 3v12M7.5 10.5L12 15l4.5-4.5",
  ruler: "M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l3 3M13 6l2 2",
  pin: "M12 21c-4-5-6-8-6-11a6 6 0 0 1 12 0c0 3-2 6-6 11M12 8a2 2 0 1 0 0 4a2 2 0 1 0 0-4",
  question: "M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.2-1.5 2.4M12 17.5v.2",
  screenshot: "M4 8h4l1.5-2.5h5L16 8h4v11H4zM12 10a3.2 3.2 0 1 0 0 6.4a3.2 3.2 0 1 0 0-6.4",
  arrow: "M12 3l7 17-7-4-7 4z",
  dive: "M3 9c3-3 6 3 9 0s6-3 9 0M3 15c3-3 6 3 9 0s6-3 9 0",
  dives: "M4 5h16M4 5v14h16V5M4 10h16M9 14h6",
  save: "M12 4v11M7 11l5 5 5-5M4 20h16",
  trash: "M5 7h14M10 7V4h4v3M7 7l1 13h8l1-13",
  sun: "M12 8a4 4 0 1 0 0 8a4 4 0 1 0 0-8M12 2v2M12 20v2M2 12h2M20 12h2",
  back: "M14 5l-7 7 7 7",
  code: "M4 4h6v6H4zM14 4h6v6h-6zM4 14h6v6H4zM14 14h2v2h-2zM18 18h2v2h-2zM18 14v.1M14 18v.1",
} as const;
export type Icon = keyof typeof ICONS;

export function icon(name: Icon): SVGSVGElement {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}

/** What the device is asked for is asked for once: until it has answered the button takes no other tap. */
export function button(name: Icon, label: string, act: () => unknown, className = "tool"): HTMLButtonElement {
  const element = el("button", className, icon(name), el("span", "label", label));
  element.type = "button";
  element.addEventListener("click", () => {
    const begun = act();
    if (!(begun instanceof Promise)) return;
    element.disabled = true;
    void begun.finally(() => {
      element.disabled = false;
    });
  });
  return element;
}

/** A button that is on or off. */
export function toggle(label: string, on: boolean, flip: () => void): HTMLButtonElement {
  const element = el("button", "switch", el("span", "", label), el("i", "knob"));
  element.type = "button";
  element.setAttribute("role", "switch");
  element.setAttribute("aria-checked", String(on));
  element.addEventListener("click", flip);
  return element;
}

/** Which one of several buttons is pressed. */
export function mark(buttons: Partial<Record<string, HTMLButtonElement>>, pressed: string | null): void {
  for (const [name, one] of Object.entries(buttons)) one?.setAttribute("aria-pressed", String(name === pressed));
}
