// Cameras come and go: create, duplicate, delete.
import { call } from './rpc.js';
import { attempt, tell } from './messages.js';
import { adopt, select, selectedCamera, state } from './state.js';

const dialog = document.getElementById('new-camera');
const form = dialog.querySelector('form');
const confirmed = document.getElementById('confirm');
// What camera.get tells and a new camera must not have: its identity, and devices that only one camera can feed.
const notCopied = ['name', 'id', 'sequence', 'readers', 'applied_ns', 'arrives_ns', 'outputs'];

/** NAME_2, NAME_3, ..: the first that is free, within the 24 characters of a name. */
function freeName(base) {
  const taken = new Set(state.cameras.map((camera) => camera.name));
  const stem = base.replace(/_\d+$/, '').slice(0, 20);
  for (let number = 2; ; number += 1) if (!taken.has(`${stem}_${number}`)) return `${stem}_${number}`;
}

document.getElementById('create').addEventListener('click', () => {
  const camera = selectedCamera();
  const places = form.elements.place;
  places.replaceChildren(...(state.world?.places ?? []).map((place) => new Option(place, place)));
  if (camera) places.prepend(new Option(`where ${camera.name} is`, ''));
  else if (!places.length) places.add(new Option('the origin', ''));
  places.selectedIndex = 0;
  form.elements.name.value = freeName(camera?.name ?? 'camera');
  dialog.returnValue = 'cancel';
  dialog.showModal();
  form.elements.name.select();
});
form.querySelector('[value=cancel]').addEventListener('click', () => dialog.close('cancel'));

// The dialog stays open until the rig has taken the camera, so that what was typed is not lost.
form.addEventListener('submit', (event) => {
  event.preventDefault();
  const { name, place, width, height, fps, device } = form.elements;
  const like = place.value ? null : selectedCamera();
  const wish = { name: name.value.trim(), size: [Number(width.value), Number(height.value)] };
  wish.fps = fps.value.includes('/') ? fps.value.trim() : Number(fps.value);
  if (place.value) wish.place = place.value;
  if (like) {
    const { position, orientation } = like.mount ? like.world_pose : like.pose;
    wish.pose = { position, orientation };
    wish.vfov_deg = Math.min(like.vfov_deg, 170);
  }
  if (device.value) wish.outputs = [{ kind: 'device', number: Number(device.value) }];
  attempt(async () => {
    adopt(await call('camera.create', wish));
    select(wish.name);
    dialog.close('ok');
  });
});

document.getElementById('duplicate').addEventListener('click', () => attempt(async () => {
  const { name } = selectedCamera();
  const camera = await call('camera.get', { name });
  for (const key of notCopied) delete camera[key];
  const made = await call('camera.create', { ...camera, name: freeName(name) });
  adopt(made);
  select(made.name);
  tell(`${made.name} is a copy of ${name}`, 'note');
}));

document.getElementById('delete').addEventListener('click', () => {
  const { name } = selectedCamera();
  document.getElementById('confirm-title').textContent = `Delete ${name}?`;
  confirmed.returnValue = '';
  confirmed.showModal();
  confirmed.onclose = () => {
    if (confirmed.returnValue !== 'ok') return;
    attempt(async () => {
      await call('camera.delete', { name });
      state.cameras = state.cameras.filter((camera) => camera.name !== name);
      select(state.cameras[0]?.name ?? null);
    });
  };
});
