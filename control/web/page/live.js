// Reads GET /live: pictures of several cameras on one connection, because a browser opens only six to a host.

import { state, upToDate } from './state.js';

const largestPart = 64 << 20;

/** The parts of a multipart body, as {fields, body}; ends with it. */
export async function* partsOf(stream) {
  const reader = stream.getReader();
  let bytes = new Uint8Array(1 << 16);
  let begin = 0;
  let end = 0;
  const more = async () => {
    const { value, done } = await reader.read();
    if (done) return false;
    if (end - begin + value.length > largestPart) throw new Error('a picture is larger than 64 MiB');
    if (end + value.length > bytes.length) {
      const room = new Uint8Array(Math.max(bytes.length, 2 * (end - begin + value.length)));
      room.set(bytes.subarray(begin, end));
      [bytes, begin, end] = [room, 0, end - begin];
    }
    bytes.set(value, end);
    end += value.length;
    return true;
  };
  const text = new TextDecoder();
  for (;;) {
    let head = -1;
    for (let from = begin; head < 0; ) {
      for (let i = from; i + 3 < end && head < 0; i += 1)
        if (bytes[i] === 13 && bytes[i + 1] === 10 && bytes[i + 2] === 13 && bytes[i + 3] === 10) head = i - begin;
      if (head >= 0) break;
      const scanned = Math.max(0, end - begin - 3);
      if (!(await more())) return;
      from = begin + scanned;
    }
    const fields = new Map(text.decode(bytes.subarray(begin, begin + head)).split('\r\n')
      .map((line) => line.split(': ', 2)).filter((pair) => pair.length === 2));
    if (!fields.has('Content-Length')) return;  // the closing boundary
    const length = Number(fields.get('Content-Length'));
    begin += head + 4;
    while (end - begin < length) if (!(await more())) return;
    yield { fields, body: bytes.slice(begin, begin + length) };
    begin += length;
  }
}

/** All that is said of cameras but what each frame and reader changes. */
const descriptionOf = (cameras) => JSON.stringify(cameras.map(({ sequence, readers, ...rest }) => rest));

/** Keeps a stream of pictures open until it is stopped; whoever has a hidden page stops it. */
export class LiveReader {
  #wanted = '';
  #abort = null;
  #onPicture;
  #onProblem;
  #seen = new Set();     // cameras of which a picture has come
  #described = '';       // what was said of the wanted cameras when the stream was opened
  #arrived = false;      // a picture, since the last look

  /** onPicture({camera, sequence, blob}) and onProblem(message). */
  constructor(onPicture, onProblem) {
    this.#onPicture = onPicture;
    this.#onProblem = onProblem;
  }

  /** The cameras that are wanted now, as camera.list gives them; query as of /live. Called at every look. */
  want(cameras, query) {
    const key = cameras.length ? `live?cameras=${cameras.map((camera) => camera.name).join(',')}&${query}` : '';
    if (key === this.#wanted && !this.#missed(cameras)) return;
    this.#wanted = key;
    this.#described = descriptionOf(cameras);
    this.#abort?.abort();
    this.#abort = null;
    this.#seen.clear();
    if (!key) return;
    this.#abort = new AbortController();
    this.#keepReading(key, this.#abort.signal);
  }

  /** In lockstep nothing falls due when a camera is changed, and its newest frame keeps its number: opening the stream
   *  again brings that frame as it is drawn now. */
  #missed(cameras) {
    const quiet = !this.#arrived;
    this.#arrived = false;
    return quiet && state.world?.mode === 'lockstep' && this.#seen.size > 0 && descriptionOf(cameras) !== this.#described;
  }

  async #keepReading(url, signal) {
    while (!signal.aborted) {
      try {
        await this.#read(url, signal);
      } catch (problem) {
        if (signal.aborted) return;
        this.#onProblem(problem.message);
      }
      // A stream ends when a camera goes or changes: what is wanted next follows from what is there now.
      await upToDate();
    }
  }

  async #read(url, signal) {
    const reply = await fetch(url, { signal });
    if (!reply.ok) throw new Error((await reply.json()).error.message);
    for await (const { fields, body } of partsOf(reply.body)) {
      if (signal.aborted) return;
      if (!fields.has('X-Camera')) continue;  // a sign of life
      const [camera, sequence] = [fields.get('X-Camera'), Number(fields.get('X-Sequence'))];
      this.#seen.add(camera);
      this.#arrived = true;
      this.#onPicture({ camera, sequence, blob: new Blob([body], { type: 'image/jpeg' }) });
    }
  }
}

/** Draws blobs on a canvas, the newest next; those that come while one is being decoded are left out. */
export class Painter {
  #canvas;
  #next = null;
  #busy = false;
  frames = 0;

  constructor(canvas) { this.#canvas = canvas; }

  async paint(blob) {
    this.#next = blob;
    if (this.#busy) return;
    this.#busy = true;
    while (this.#next) {
      const now = this.#next;
      this.#next = null;
      const bitmap = await createImageBitmap(now).catch(() => null);
      if (!bitmap) continue;
      const canvas = this.#canvas;
      if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
      canvas.getContext('2d').drawImage(bitmap, 0, 0);
      bitmap.close();
      this.frames += 1;
      canvas.dataset.frames = String(this.frames);
    }
    this.#busy = false;
  }
}
