// Where the calibrated camera shows what is in metres: the grid, the figure with its shadow, boxes. The rig's own lens says it (plate.project); while it
// answers, the newest wish waits.
import { call } from './rpc.js';
import { measure } from './plate_measure.js';
import { boxesOf, footOf } from './plate_shapes.js';
import { change, listen, plate } from './plate_state.js';
import { tell } from './messages.js';

const mostAtOnce = 4096;
const widestGrid = 50;   // metres
const figureHeight = 1.75;

// The figure: right half of its outline as [to the right, up], from between the feet to the neck, and its head.
const half = [[0.02, 0], [0.13, 0], [0.15, 0.84], [0.26, 0.84], [0.23, 1.4], [0.07, 1.48], [0.07, 1.52]];
const head = Array.from({ length: 9 }, (_, i) => [0.12 * Math.sin((Math.PI * (8 - i)) / 8), 1.62 - 0.13 * Math.cos((Math.PI * (8 - i)) / 8)]);
const right = [[0, 0.78], ...half, ...head.toReversed()];
const outline = [...right, ...right.slice(1, -1).toReversed().map(([x, z]) => [-x, z])];

async function project(camera, { points = [], pixels = [], z = 0 }) {
  const all = { px: [], m: [] };
  for (let from = 0; from < Math.max(points.length, pixels.length); from += mostAtOnce) {
    const part = { points: points.slice(from, from + mostAtOnce), pixels: pixels.slice(from, from + mostAtOnce) };
    const { px, m } = await call('plate.project', { camera, z, ...part });
    all.px.push(...px);
    all.m.push(...m);
  }
  return all;
}

/** Metres on the ground of pixels; null over the horizon. */
export async function onGround(camera, pixels) { return (await project(camera, { pixels })).m; }

/** From where to where the grid goes, [x0, y0, x1, y1] in whole metres; null: the camera sees no ground nearby. */
async function gridExtent(camera) {
  const [width, height] = camera.size;
  const pixels = Array.from({ length: 49 }, (_, i) => [((i % 7) * (width - 1)) / 6, (Math.floor(i / 7) * (height - 1)) / 6]);
  const [x, y, z] = camera.pose.position;
  const near = (await onGround(camera, pixels)).filter((m) => m && Math.hypot(m[0] - x, m[1] - y) < 40 + 2 * Math.abs(z));
  if (near.length === 0) return null;
  const range = (axis) => {
    const all = near.map((m) => m[axis]);
    const [low, high] = [Math.floor(Math.min(...all)), Math.ceil(Math.max(...all))];
    const middle = Math.round((low + high) / 2);
    return [Math.max(low, middle - widestGrid / 2), Math.min(high, middle + widestGrid / 2)];
  };
  const [[x0, x1], [y0, y1]] = [range(0), range(1)];
  return [x0, y0, x1, y1];
}

async function gridOf(camera) {
  const extent = await gridExtent(camera);
  if (!extent) return { columns: 0, px: [] };
  const [x0, y0, x1, y1] = extent;
  const points = [];
  for (let y = y0; y <= y1; y += 1) for (let x = x0; x <= x1; x += 1) points.push([x, y, 0]);
  const { px } = await project(camera, { points });
  return { columns: x1 - x0 + 1, px };
}

/** Outline of the figure at a place, upright and facing the camera, and of its shadow. */
function figureAt([x, y], camera, light) {
  const [dx, dy] = [x - camera.pose.position[0], y - camera.pose.position[1]];
  const far = Math.hypot(dx, dy) || 1;
  const body = outline.map(([side, up]) => [x + (side * dy) / far, y - (side * dx) / far, up]);
  const sun = light?.lights[0].direction;
  const shadow = sun ? body.map(([u, v, up]) => [u - (sun[0] / sun[2]) * up, v - (sun[1] / sun[2]) * up, 0]) : [];
  return { body, shadow };
}

const cuboid = (box) => [0, box.size[2]].flatMap((z) => footOf(box).map((corner) => [...corner, z]));

let grid = null;       // of `gridCamera`, made once for each
let gridCamera = null;

async function look(camera) {
  if (gridCamera !== camera) {
    grid = await gridOf(camera);
    gridCamera = camera;
  }
  const { figure, shapes, light, measured } = plate;
  const onTheGround = shapes.map((shape) => (shape.kind === 'cutout' ? [shape.px.at(-1)] : shape.px));
  const pixels = [...onTheGround.flat(), ...(figure?.px ? [figure.px] : [])];
  const m = pixels.length ? await onGround(camera, pixels) : [];
  const ground = onTheGround.map((corners) => m.splice(0, corners.length));
  // Dragged over the horizon it stays where it was.
  const place = (figure?.px ? m[0] : figure?.m) ?? plate.shown.place;
  const boxes = shapes.map((shape, index) => (ground[index].includes(null) ? [] : boxesOf(shape, ground[index], camera.pose.position)));
  const { body, shadow } = place ? figureAt(place, camera, light) : { body: [], shadow: [] };
  const points = [...body, ...shadow, ...(place ? [[place[0], place[1], 0], [place[0], place[1], figureHeight]] : []), ...boxes.flat().flatMap(cuboid)];
  const px = points.length ? (await project(camera, { points })).px : [];
  const metres = await measure(camera, measured, project);
  const take = (count) => px.splice(0, count);
  return {
    grid, ground, boxes, place: place ?? null, body: take(body.length), shadow: take(shadow.length), standing: place ? take(2) : [],
    cuboids: boxes.flat().map(() => take(8)), metres,
  };
}

let asked = [];
let isAsking = false;

async function keepUp() {
  if (isAsking) return;
  isAsking = true;
  for (;;) {
    const wish = [plate.found?.camera, plate.figure, plate.shapes, plate.light, plate.measured];
    if (wish.every((one, index) => one === asked[index])) break;
    asked = wish;
    try {
      change({ shown: wish[0] ? await look(wish[0]) : {} });
    } catch (problem) {
      tell(problem.message);
    }
  }
  isAsking = false;
}
listen(keepUp);
