// Cameras on pan/tilt/zoom heads (ptz.*): how they are driven, and the panel of where they look and of their presets.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { listen, selectedCamera } from './state.js';

const panel = document.getElementById('head');
const facts = document.getElementById('head-facts');
const presets = panel.querySelector('[name=preset]');
const fastest = { turn: 60, zoom: 1 };  // deg/s and share of the head's zoom speed at the picture's edge
// A continuous move ends by itself so soon after the page has gone; while it goes on, it is said anew.
const timeoutS = 1;
const againMs = 500;

export const hasHead = (camera) => Boolean(camera?.ptz);

// Per camera the commands that wait while one is on its way, in their order. A drive takes the place of a drive that waits, so does where to
// zoom to, and relative steps are added up: a head is told where to go, not how the hand went there.
const waiting = new Map();
const mostWaiting = 8;

const modeOf = ([method, params]) => (method === 'ptz.move' ? params.mode : method);
const sum = (a, b) => ({
  mode: 'relative', pan_deg: (a.pan_deg ?? 0) + (b.pan_deg ?? 0), tilt_deg: (a.tilt_deg ?? 0) + (b.tilt_deg ?? 0), zoom: (a.zoom ?? 1) * (b.zoom ?? 1),
});

/** What a step does not move goes on with what it does. */
function onlyMoved(params) {
  const { pan_deg, tilt_deg, zoom, ...rest } = params;
  return { ...rest, ...(pan_deg || tilt_deg ? { pan_deg, tilt_deg } : {}), ...(zoom === 1 ? {} : { zoom }) };
}

/** Commands go to a head one after the other; what it answers is shown. */
export async function tellHead(name, method, params) {
  const command = [method, params];
  const queue = waiting.get(name);
  if (queue) {
    const last = queue.at(-1);
    if (last && modeOf(last) === modeOf(command) && modeOf(command) === 'relative') last[1] = sum(last[1], params);
    else if (last && modeOf(last) === modeOf(command) && ['continuous', 'absolute'].includes(modeOf(command))) last[1] = params;
    else if (queue.length < mostWaiting) queue.push(command);
    return;
  }
  waiting.set(name, [command]);
  for (let next; (next = waiting.get(name).shift());) {
    const [nextMethod, nextParams] = next;
    const asked = nextParams.mode === 'relative' ? onlyMoved(nextParams) : nextParams;
    const answered = await attempt(() => call(nextMethod, { camera: name, ...asked }));
    if (answered) show(name, answered);
  }
  waiting.delete(name);
}

export function stepHead(camera, pan, tilt, zoom = 1) {
  tellHead(camera.name, 'ptz.move', { mode: 'relative', pan_deg: pan, tilt_deg: tilt, zoom });
}

/** Zooms to that factor of the focal length, or as near to it as the head comes. */
export function zoomHeadTo(camera, zoom) {
  tellHead(camera.name, 'ptz.move', { mode: 'absolute', zoom: Math.max(1, Math.min(camera.ptz.zoom_max, zoom)) });
}

/** Factor of the focal length that its head has brought; 1 without one. */
export const zoomOf = (camera) => camera.shown_intrinsics.fx / camera.intrinsics.fx;
/** A field of view (degrees) at that zoom. */
export const shownFov = (camera, degrees) => 2 * Math.atan(Math.tan(Math.min(degrees, 179.9) * Math.PI / 360) / zoomOf(camera)) * 180 / Math.PI;

let drive = null;  // { name, params, timer }

/** Goes on at that share of the fastest, -1 to 1, right and up positive, until haltHead(). */
export function driveHead(camera, right, up) {
  const turn = fastest.turn / zoomOf(camera);
  const params = { mode: 'continuous', pan_deg: -right * turn, tilt_deg: up * turn, timeout_s: timeoutS };
  const say = () => tellHead(drive.name, 'ptz.move', drive.params);
  if (drive) {
    drive.params = params;
  } else {
    drive = { name: camera.name, params, timer: setInterval(() => say(), againMs) };
  }
  say();
}

export function haltHead() {
  if (!drive) return;
  clearInterval(drive.timer);
  tellHead(drive.name, 'ptz.stop', { pan_tilt: true, zoom: false });
  drive = null;
}

/** What the picture shows there, -1 to 1 to the right and upwards, comes to its middle. */
export function aimHead(camera, x, y) { tellHead(camera.name, 'ptz.move', { mode: 'fov', x, y }); }

const statusListeners = [];
/** `run(status)` with every ptz.status of the selected camera's head. */
export const onStatus = (run) => statusListeners.push(run);

function show(name, status) {
  if (selectedCamera()?.name !== name) return;
  for (const run of statusListeners) run(status);
  const number = (value, digits) => String(Number(value.toFixed(digits)));
  facts.textContent = `pan ${number(status.pan_deg, 1)}° · tilt ${number(status.tilt_deg, 1)}° · zoom ${number(status.zoom, 2)} · ` +
    (status.turning || status.zooming ? 'moving' : 'stands');
  const names = Object.keys(status.presets);
  if (names.join('\n') === [...presets.options].map((option) => option.value).join('\n')) return;
  const chosen = presets.value;
  presets.replaceChildren(...names.map((one) => new Option(one, one)));
  if (names.includes(chosen)) presets.value = chosen;
  for (const button of panel.querySelectorAll('[data-preset]')) button.disabled = names.length === 0;
}

let isAsking = false;
listen(async () => {
  const camera = selectedCamera();
  panel.hidden = !hasHead(camera);
  if (panel.hidden || isAsking) return;
  isAsking = true;
  try {
    show(camera.name, await call('ptz.status', { camera: camera.name }));
  } catch {
    // A camera that is gone, or has no head any more, is told by the next look.
  }
  isAsking = false;
});

for (const button of panel.querySelectorAll('[data-method]')) {
  button.addEventListener('click', () => {
    const { name } = selectedCamera();
    const params = 'preset' in button.dataset ? { preset: presets.value } : {};
    tellHead(name, button.dataset.method, params);
  });
}
panel.querySelector('form').addEventListener('submit', (event) => {
  event.preventDefault();
  const { name } = event.target.elements;
  tellHead(selectedCamera().name, 'ptz.preset_set', { preset: name.value.trim() });
  name.value = '';
});
