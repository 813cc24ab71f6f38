// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Vec3 } from "../wire/records";

/** Survey coordinates are large doubles, the graphics card's are floats: the scene starts at the first point seen. */
export class Origin {
  private at: Vec3 | null = null;

  get point(): Vec3 {
    return this.at ?? [0, 0, 0];
  }

  toScene(inSurvey: Vec3): Vec3 {
    this.at ??= inSurvey;
    const at = this.at;
    return [inSurvey[0] - at[0], inSurvey[1] - at[1], inSurvey[2] - at[2]];
  }

  forget(): void {
    this.at = null;
  }
}
