/** The worker's side: one model, one answer a question. Built into a text of its own, from which the page makes the worker. */

import type { Live } from "../types";
import { LiveModel } from "./model";
import { answer, type Question } from "./questions";

let model: LiveModel | null = null;

interface Port { onmessage: ((event: MessageEvent<{ live?: Live; question?: Question }>) => void) | null; postMessage(message: unknown): void }
const port = self as unknown as Port;
port.onmessage = (event) => {
  const { live, question } = event.data;
  if (live) model = new LiveModel(live);
  if (model && question) port.postMessage(answer(model, question));
};
