// The scene file: the camera with its photo, shapes, light and people who walk there (docs/scene-format.md). To be put beside the photo.
import { onGround } from './plate_view.js';
import { baseName } from './plate_photo.js';
import { boxesOf, footOf, placesIn, roleOf } from './plate_shapes.js';
import { sceneLight } from './plate_light.js';
import { change, listen, plate } from './plate_state.js';
import { call } from './rpc.js';
import { attempt, tell } from './messages.js';

const form = document.getElementById('save');
const text = document.getElementById('scene');
const people = ['anna', 'ben', 'clara', 'david', 'emma', 'frank', 'greta', 'hugo', 'ivan', 'julia', 'karl'];

/** The shapes as `proxies` of a backdrop, and where people may walk, in metres. */
async function proxiesOf(camera) {
  const proxies = { boxes: [], cutouts: [], walkable: [] };
  for (const [index, shape] of plate.shapes.entries()) {
    const ground = await onGround(camera, shape.kind === 'cutout' ? shape.px.slice(-1) : shape.px);
    const over = ground.indexOf(null);
    if (over >= 0) {
      const problem = `${shape.kind === 'cutout' ? 'its foot' : `corner ${over + 1}`} is over the horizon of the ground`;
      change({ problem: { of: `shapes[${index}]`, text: problem } });
      throw new Error(`shape ${index + 1}: ${problem}`);
    }
    if (shape.kind === 'walkable') proxies.walkable.push({ polygon_m: ground.map(([x, y]) => [x, y]) });
    else if (shape.kind === 'cutout') proxies.cutouts.push({ polygon_px: shape.px.slice(0, -1), foot_px: shape.px.at(-1), ...roleOf(shape) });
    else proxies.boxes.push(...boxesOf(shape, ground, camera.pose.position));
  }
  return Object.fromEntries(Object.entries(proxies).filter(([, list]) => list.length));
}

/** People who walk about in what is walkable; without that one stands where the figure does. */
function actorsOf({ walkable = [], boxes = [] }, count) {
  const obstacles = boxes.map(footOf);
  const areas = Object.fromEntries(walkable.map(({ polygon_m: points }, index) => [`walkable_${index + 1}`, { points, ...(obstacles.length ? { obstacles } : {}) }]));
  const standing = plate.shown.place?.slice(0, 2) ?? [0, 0];
  const places = walkable.map(({ polygon_m: polygon }) => placesIn(polygon, obstacles, count));
  const actors = Array.from({ length: walkable.length ? count : Math.min(count, 1) }, (_, index) => {
    const name = people[index % people.length];
    const where = index % Math.max(walkable.length, 1);
    const place = walkable.length ? places[where][Math.floor(index / walkable.length)] : standing;
    if (!place) throw new Error(`there is no room for ${count} people in what is walkable`);
    const behaviour = { type: 'wander', area: `walkable_${where + 1}`, clip: 'walk', idle_clip: 'idle' };
    return { name: index < people.length ? name : `${name}_${Math.floor(index / people.length) + 1}`, model: name, class: 'person', position: [...place, 0], ...(walkable.length ? { behaviour } : {}) };
  });
  const models = Object.fromEntries(actors.map(({ model }) => [model, { file: `camrig:people/${model}` }]));
  return { models, ...(walkable.length ? { areas } : {}), actors };
}

/** Without what is null or empty. */
const tidied = (values) => Object.fromEntries(Object.entries(values).filter(([, value]) => value != null && value !== '' && value.length !== 0));

/** The backdrop with what was drawn and found; what a camera of the rig had stays. */
async function backdropOf({ picture_size: ignored, proxies: given = {}, ...kept }) {
  const { found } = plate;
  const drawn = await proxiesOf(found.camera);
  const level = given.ground ?? found.ground;
  const ground = level && plate.groundRole ? { ...level, role: plate.groundRole } : level;
  const joined = ['boxes', 'cutouts', 'walkable'].map((key) => [key, [...(given[key] ?? []), ...(drawn[key] ?? [])]]);
  const proxies = tidied({ ...given, ground, ...Object.fromEntries(joined) });
  if (!ground && !Object.keys(drawn).length && !given.file) throw new Error('the camera sees no ground; draw something that people go behind');
  return { backdrop: tidied({ ...kept, intrinsics: found.camera.intrinsics, proxies }), drawn };
}

function checkFound({ found, isStale }) {
  if (!found) throw new Error('calibrate the photo first');
  if (found.verdict && isStale) throw new Error('clicks have changed: calibrate again');
}

async function sceneOf({ name, camera: cameraName, width, count }) {
  const { found, photo } = plate;
  checkFound(plate);
  const { lens, pose, size } = found.camera;
  const { backdrop, drawn } = await backdropOf(photo.camera?.backdrop ?? {});
  backdrop.file = photo.file;
  // Files lie beside the scene file, which has none of the objects of the rig's scene.
  if (backdrop.proxies.file) backdrop.proxies.file = baseName(backdrop.proxies.file);
  delete backdrop.proxies.scene;
  const camera = { name: cameraName, size: [width, Math.round((width * size[1]) / size[0])], ...(lens ? { lens } : {}), pose, backdrop };
  return { camrig_scene: 1, name, ...sceneLight(), ...actorsOf(drawn, count), cameras: [camera] };
}

/** Readable, but numbers of a list on one line. */
function textOf(scene) {
  return JSON.stringify(scene, null, 1).replace(/\[[^[\]{}]*\]/g, (list) => list.replace(/\s+/g, ' ').replace('[ ', '[').replace(' ]', ']')) + '\n';
}

async function make() {
  const { name, camera, width, people: count } = form.elements;
  const scene = await sceneOf({ name: name.value, camera: camera.value, width: Number(width.value), count: Number(count.value) });
  text.value = textOf(scene);
  text.hidden = false;
  return text.value;
}

form.addEventListener('submit', (event) => {
  event.preventDefault();
  attempt(async () => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([await make()], { type: 'application/json' }));
    link.download = `${form.elements.name.value}.json`;
    link.click();
    URL.revokeObjectURL(link.href);
    tell(`put it beside ${plate.photo.file}, then: camrig check ${link.download}; camrig serve ${link.download}`, 'note');
  });
});
document.getElementById('copy').addEventListener('click', () => attempt(async () => {
  await make();
  text.select();
  // Beyond localhost plain HTTP has no clipboard; the older way works from a click.
  await navigator.clipboard?.writeText(text.value).catch(() => document.execCommand('copy'));
  tell('copied, if the browser lets pages copy; else press Ctrl-C', 'note');
}));

// A camera of the rig has what was found and drawn at once; its shapes are then those that it was chosen with.
const applyButton = document.getElementById('apply');
applyButton.addEventListener('click', () => attempt(async () => {
  checkFound(plate);
  const { found, photo } = plate;
  const { backdrop } = await backdropOf(photo.camera.backdrop);
  const { name } = await call('camera.set', { name: photo.camera.name, pose: found.camera.pose, ...(found.camera.lens ? { lens: found.camera.lens } : {}), backdrop });
  tell(`camera ${name} has it`, 'note');
}));

let named = null;
listen(({ photo, found }) => {
  for (const control of form.elements) if (control.type !== 'textarea') control.disabled = !found;
  applyButton.hidden = !photo?.camera;
  if (!photo || named === photo) return;
  named = photo;
  const stem = photo.file.replace(/\.[^.]*$/, '');
  form.elements.name.value = stem;
  form.elements.camera.value = photo.camera?.name ?? (stem.toLowerCase().replace(/[^a-z0-9_]+/g, '_').slice(0, 24) || 'plate');
  form.elements.width.value = photo.camera?.size[0] ?? Math.min(photo.size[0], 1920);
  form.elements.width.max = Math.min(photo.size[0], 8192);
});
