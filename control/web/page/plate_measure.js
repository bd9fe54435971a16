// What is measured in the photo: how far two places on the ground are apart, and how tall is what stands on it. The rig's lens says where pixels look.
import { change, listen, plate, withOne } from './plate_state.js';

const labels = { distance: 'Distance', standing: 'Height' };
const holder = document.getElementById('measured');

/** How high over its foot something upright reaches that the ray through `along` meets, from the camera at `eye`: where it comes nearest. */
function heightOf(foot, eye, along) {
  const length = Math.hypot(...along);
  const ray = along.map((value) => value / length);
  const from = eye.map((value, i) => value - foot[i]);
  const level = 1 - ray[2] ** 2;
  return level < 1e-6 ? null : (from[2] - ray[2] * from.reduce((sum, value, i) => sum + value * ray[i], 0)) / level;
}

/** Metres of each; null: over the horizon. project(camera, {pixels, z}) answers with `m`. */
export async function measure(camera, measured, project) {
  if (measured.length === 0) return [];
  const eye = camera.pose.position;
  const pixels = measured.flatMap(({ px }) => px);
  const [ground, below, above] = (await Promise.all([0, eye[2] - 1, eye[2] + 1].map((z) => project(camera, { pixels, z })))).map(({ m }) => m);
  return measured.map(({ kind }, index) => {
    const [one, other] = [2 * index, 2 * index + 1];
    if (!ground[one]) return null;
    if (kind === 'distance') return ground[other] && Math.hypot(ground[one][0] - ground[other][0], ground[one][1] - ground[other][1]);
    // A ray to the horizon meets neither.
    const at = below[other] ?? above[other];
    return at ? heightOf(ground[one], eye, at.map((value, i) => value - eye[i])) : eye[2] - ground[one][2];
  });
}

/** What is said of one, in the photo and in the list. */
export function textOf(metres) {
  if (metres === undefined) return '';
  return metres === null ? 'over the horizon of the ground' : `${metres.toFixed(2)} m`;
}

const rows = [];

function makeRow(index) {
  const row = document.createElement('li');
  const name = document.createElement('b');
  const value = document.createElement('output');
  const remove = document.createElement('button');
  remove.type = 'button';
  remove.textContent = '×';
  remove.setAttribute('aria-label', `Remove measure ${index + 1}`);
  remove.addEventListener('click', () => change({ measured: withOne(plate.measured, index, undefined) }));
  row.append(name, value, remove);
  holder.append(row);
  return { row, name, value };
}

listen(({ measured, found, shown }) => {
  while (rows.length > measured.length) rows.pop().row.remove();
  while (rows.length < measured.length) rows.push(makeRow(rows.length));
  rows.forEach(({ name, value }, index) => {
    name.textContent = labels[measured[index].kind];
    value.textContent = found ? textOf(shown.metres?.[index]) : 'calibrate first';
  });
});
