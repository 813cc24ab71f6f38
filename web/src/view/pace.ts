// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// When the scene is drawn: with the browser's next picture for the viewer's hand; for what the server tells, in a part
// of the time, since a page that is told much is to decode it, too.

/** News are drawn in one part of so many of the time, and in less while much is told at once. */
const NEWS_SHARE = 4;
const CATCHING_UP = { share: 10, ms: 1500 };
const MOST_COST_MS = 500;
const MEASURE_MS = 8;

export class Pace {
  /** Much is told at once: it is drawn now and then. */
  isCatchingUp: () => boolean = () => false;
  private asked = false;
  private drawnAt = 0;
  /** How long the graphics card took for a picture, ms, and whether it draws one that is measured. */
  private cost = 0;
  private drawing = false;
  private hasNews = false;
  private news: ReturnType<typeof setTimeout> | undefined;

  /** render draws, told when and how long after the picture before; true: the scene moves on by itself. */
  constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly render: (now: number, seconds: number) => boolean,
  ) {}

  /** What was asked for is on the screen. */
  get isSettled(): boolean {
    return !this.asked && !this.drawing && !this.hasNews;
  }

  draw(): void {
    // The first picture keeps the page from all else for long: what is told meanwhile is to be unpacked beside it.
    if (this.drawnAt === 0 && this.isCatchingUp()) this.drawNews();
    else this.ask();
  }

  private ask(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => {
      this.begin(now);
    });
  }

  /** For what may wait. */
  drawNews(): void {
    this.hasNews = true;
    if (this.asked || this.drawing || this.news !== undefined) return;
    const pause = this.isCatchingUp() ? Math.max(CATCHING_UP.share * this.cost, CATCHING_UP.ms) : NEWS_SHARE * this.cost;
    this.news = setTimeout(() => {
      this.news = undefined;
      this.ask();
    }, Math.max(0, this.drawnAt + pause - performance.now()));
  }

  private begin(now: number): void {
    this.asked = this.hasNews = false;
    clearTimeout(this.news);
    this.news = undefined;
    const seconds = (now - this.drawnAt) / 1000;
    this.drawnAt = now;
    const moving = this.render(now, seconds);
    this.measure(performance.now());
    if (moving && this.isCatchingUp()) this.drawNews();
    else if (moving) this.ask();
  }

  /** Waits until the graphics card has drawn what was begun. */
  private measure(begun: number): void {
    if (this.drawing) return;
    const { gl } = this;
    const done = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (done === null) return;
    gl.flush();
    this.drawing = true;
    const look = () => {
      if (gl.getSyncParameter(done, gl.SYNC_STATUS) !== gl.SIGNALED && performance.now() - begun < MOST_COST_MS) {
        setTimeout(look, MEASURE_MS);
        return;
      }
      gl.deleteSync(done);
      // The browser lays it on the page before it asks for another.
      requestAnimationFrame(() => {
        this.drawing = false;
        this.cost = Math.min(MOST_COST_MS, performance.now() - begun);  // a hidden page waits for ever
        if (this.hasNews) this.drawNews();
      });
    };
    setTimeout(look, MEASURE_MS);
  }
}
