// Which photo: a file of the user's, which stays in the browser, or that of a camera of the rig.
import { call } from './rpc.js';
import { change, listen, plate } from './plate_state.js';
import { attempt } from './messages.js';

const file = document.getElementById('photo-file');
const choice = document.getElementById('photo-camera');
const empty = { drawing: [], points: [], heights: [], lines: [], shapes: [], groundRole: null, measured: [], problem: null, isStale: false, figure: null, found: null, shown: {} };

export const baseName = (path) => path.split('/').at(-1);

let newest = null;  // choice: what an older one brings comes too late
let taken = null;
const take = () => attempt(async () => {
  const [chosen] = file.files;
  if (!chosen || chosen === taken) return;
  taken = chosen;
  newest = chosen;
  const bitmap = await createImageBitmap(chosen).catch(() => { throw new Error(`${chosen.name}: is no picture that this browser reads; give PNG or JPEG`); });
  if (newest !== chosen) return;
  choice.value = '';
  change({ ...empty, photo: { bitmap, size: [bitmap.width, bitmap.height], file: chosen.name, camera: null } });
});
file.addEventListener('change', take);
take();  // somebody may have been faster than this script, and is told of by an event besides

async function list() {
  const { cameras } = await call('camera.list');
  const plates = cameras.filter(({ backdrop }) => backdrop?.kind === 'plate');
  choice.replaceChildren(new Option(plates.length ? 'choose one' : 'none has a photo', ''), ...plates.map(({ name }) => new Option(name)));
  choice.value = plate.photo?.camera?.name ?? '';
}

choice.addEventListener('change', () => attempt(async () => {
  if (!choice.value) return;
  const chosen = {};
  newest = chosen;
  const camera = await call('camera.get', { name: choice.value });
  const reply = await fetch(`cameras/${encodeURIComponent(camera.name)}/snapshot.png`);
  if (!reply.ok) throw new Error((await reply.json()).error.message);
  const bitmap = await createImageBitmap(await reply.blob());
  if (newest !== chosen) return;
  const { backdrop } = camera;
  // Its pixels are those of the photo, whatever the size of the stream.
  const size = backdrop.picture_size ?? camera.size;
  const intrinsics = Object.fromEntries(Object.entries(camera.intrinsics).map(([key, value]) => {
    const ratio = key.endsWith('x') ? size[0] / camera.size[0] : size[1] / camera.size[1];
    return [key, key.startsWith('c') ? (value + 0.5) * ratio - 0.5 : value * ratio];
  }));
  const { lens: { model, coefficients }, pose: { position, pan_deg, tilt_deg, roll_deg } } = camera;
  file.value = '';
  change({
    ...empty, photo: { bitmap, size, file: baseName(backdrop.file), camera },
    found: { camera: { size, intrinsics, lens: { model, coefficients }, pose: { position, pan_deg, tilt_deg, roll_deg } }, ground: backdrop.proxies.ground ?? null },
    figure: { px: [size[0] / 2, size[1] * 0.8] },
  });
}));

listen(({ photo }) => {
  document.getElementById('photo-facts').textContent = photo ? `${photo.file} · ${photo.size.join('×')}` : 'PNG or JPEG, with nobody in it';
});
attempt(list);
