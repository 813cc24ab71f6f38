// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0

/** What a finger in a glove may move and still have tapped. */
const TAP_PX = 24;
const TAP_MS = 600;

/** Calls onTap with where an element was tapped, CSS px from its upper left corner. */
export function listenForTaps(element: HTMLElement, onTap: (x: number, y: number) => void): void {
  let down: PointerEvent | null = null;
  element.addEventListener("pointerdown", (event) => {
    down = event.isPrimary ? event : null;
  });
  element.addEventListener("pointerup", (event) => {
    const moved = down === null ? Infinity : Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY);
    if (down === null || moved > TAP_PX || event.timeStamp - down.timeStamp > TAP_MS) return;
    down = null;
    const box = element.getBoundingClientRect();
    onTap(event.clientX - box.left, event.clientY - box.top);
  });
}
