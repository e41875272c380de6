/** Asks the model in a worker, one question at a time: of those that come meanwhile only the last is put. */

import source from "worker:./worker";
import type { Live } from "../types";
import { LiveModel, type Point } from "./model";
import { answer, type Answer, type Question } from "./questions";

export class Client {
  private worker: Worker | null = null;
  private local: LiveModel | null = null;
  private busy = false;
  private waiting: Question | null = null;
  private asked: Question | null = null;
  private last = 0;

  constructor(private readonly live: Live, private readonly heard: (answer: Answer) => void) {
    try {
      const url = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
      this.worker = new Worker(url);
      this.worker.onmessage = (event: MessageEvent<Answer>) => this.hear(event.data);
      // Where workers from memory are forbidden, the page computes in its own thread.
      this.worker.onerror = () => this.alone();
      this.worker.postMessage({ live });
    } catch {
      this.alone();
    }
  }

  private alone(): void {
    this.worker?.terminate();
    this.worker = null;
    this.local ??= new LiveModel(this.live);
    // The question that the worker has not answered is put again.
    if (this.busy) this.waiting ??= this.asked;
    this.busy = false;
    this.next();
  }

  /** Puts a question; returns its number. */
  ask(at: Point, way: Point[], more: Omit<Question, "id" | "at" | "way"> = {}): number {
    this.waiting = { id: ++this.last, at, way, ...more };
    this.next();
    return this.last;
  }

  private next(): void {
    if (this.busy || !this.waiting) return;
    const question = this.waiting;
    this.waiting = null;
    this.busy = true;
    if (this.worker) {
      this.asked = question;
      this.worker.postMessage({ question });
    } else if (this.local) setTimeout(() => this.hear(answer(this.local!, question)), 0);
  }

  private hear(a: Answer): void {
    this.busy = false;
    this.heard(a);
    this.next();
  }
}
