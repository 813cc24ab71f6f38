// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What this viewer chose, kept by the browser where it may.

export function recall(name: string): string | null {
  try {
    return localStorage.getItem(`nadir.${name}`);
  } catch {
    return null;
  }
}

export function remember(name: string, value: string | null): void {
  try {
    if (value === null) localStorage.removeItem(`nadir.${name}`);
    else localStorage.setItem(`nadir.${name}`, value);
  } catch {
    // Without a store the choice holds for this visit.
  }
}
