// One camera, large. With the truth shown, picture and boxes are always those of the same frame: pictures wait for
// their truth, which is made less often.
import { call } from './rpc.js';
import { LiveReader, Painter } from './live.js';
import { hasHead, shownFov } from './head.js';
import { listen, selectedCamera, state } from './state.js';
import { tell } from './messages.js';
import { clearTruth, drawTruth } from './truth.js';

const mostHeld = 120;          // pictures that wait for their truth
const widest = 1280;
const truthPauseMs = 60;
const picture = document.getElementById('picture');
const overlay = document.getElementById('overlay');
const button = document.getElementById('truth');
const painter = new Painter(picture);
const held = new Map();        // sequence -> blob, oldest first
let last = null;               // the newest picture, as long as it is of the camera that is shown
let visible = false;
let withTruth = false;
let truthLoop = null;
let pending = null;            // a truth whose picture has not come yet

const reader = new LiveReader(onPicture, (problem) => { document.getElementById('stage-facts').textContent = problem; });

function onPicture({ camera, sequence, blob }) {
  if (camera !== state.selected) return;
  last = { sequence, blob };
  if (!withTruth) { painter.paint(blob); return; }
  held.set(sequence, blob);
  while (held.size > mostHeld) held.delete(held.keys().next().value);
  if (pending) showTruth(pending);
}

function showTruth(truth) {
  const sequences = [...held.keys()];
  const blob = held.get(truth.sequence);
  const newest = sequences.at(-1);
  pending = blob === undefined && (newest === undefined || newest < truth.sequence) ? truth : null;
  if (blob === undefined) return;
  for (const sequence of sequences) if (sequence < truth.sequence) held.delete(sequence);
  painter.paint(blob);
  drawTruth(overlay, truth, overlay.clientWidth);
}

async function keepAsking(signal) {
  let lastSequence = -1;
  while (!signal.aborted) {
    const camera = state.selected;
    try {
      const truth = await call('truth.get', { camera }, signal);
      if (truth.camera === state.selected && withTruth && truth.sequence !== lastSequence) {
        lastSequence = truth.sequence;
        showTruth(truth);
      }
    } catch (problem) {
      if (signal.aborted) return;
      // A camera that is gone is told by the next look.
      if (camera === state.selected && state.connected && problem.kind !== 'not_found') tell(problem.message);
      await new Promise((next) => setTimeout(next, 1000));
    }
    await new Promise((next) => setTimeout(next, truthPauseMs));
  }
}

function readOn() {
  const camera = selectedCamera();
  const scale = camera && camera.size[0] > widest ? `&width=${widest}` : '';
  // The size in the query's `t` makes the reader open the stream again when the camera has another one.
  reader.want(visible && camera ? [camera] : [], `quality=85${scale}&t=${camera?.size.join('x')}`);
  const ask = visible && camera && withTruth;
  if (ask && !truthLoop) {
    truthLoop = new AbortController();
    keepAsking(truthLoop.signal);
  } else if (!ask && truthLoop) {
    truthLoop.abort();
    truthLoop = null;
  }
}

function restart() {
  held.clear();
  pending = null;
  clearTruth(overlay);
}

button.addEventListener('click', () => {
  withTruth = !withTruth;
  button.setAttribute('aria-pressed', String(withTruth));
  restart();
  // While the world stands still no other picture comes.
  if (withTruth && last) held.set(last.sequence, last.blob);
  else if (last) painter.paint(last.blob);
  readOn();
});

listen((_, stage) => {
  if (stage === 'selected') {
    last = null;
    restart();
  }
  const camera = selectedCamera();
  document.getElementById('stage-name').textContent = camera?.name ?? 'No camera';
  for (const id of ['truth', 'duplicate', 'delete']) document.getElementById(id).disabled = !camera;
  if (camera) {
    document.getElementById('stage-facts').textContent =
      `${camera.size.join('×')} · ${camera.fps} Hz · ${(hasHead(camera) ? shownFov(camera, camera.vfov_deg) : camera.vfov_deg).toFixed(1)}° · ${camera.lens.model} · ${camera.readers} reading`;
    picture.setAttribute('aria-label', `Picture of camera ${camera.name}`);
    document.getElementById('view').style.aspectRatio = camera.size.join(' / ');
  } else {
    document.getElementById('stage-facts').textContent = 'create one to see something';
    picture.getContext('2d').clearRect(0, 0, picture.width, picture.height);
  }
  readOn();
});

export function show() { visible = true; readOn(); }
export function hide() { visible = false; readOn(); }
