// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";
import { plain } from "../src/ui/dom";

describe("text from outside", () => {
  it("turns no other text around and hides none", () => {
    expect(plain("reef\u202egpj.exe")).toBe("reef\ufffdgpj.exe");
    expect(plain("a\u0000b\u2067c\u0085d")).toBe("a\ufffdb\ufffdc\ufffdd");
  });

  it("is left as it is in any script", () => {
    for (const text of ["Ærøskøbing, 2 m", "שונית\nצפון", "سفينة", "沈没船 1", "e\u0301", "\u{1f41f}"]) expect(plain(text)).toBe(text);
  });
});
