// The photo, and over it all that was clicked, drawn or found. A click does what the tool does; marks and the figure are dragged; the wheel enlarges.
// Pixels are the photo's, with centres at integers.
import { change, changeClicks, handles, listen, plate } from './plate_state.js';
import { textOf } from './plate_measure.js';
import { kinds } from './plate_shapes.js';
import { shadowClicked } from './plate_light.js';

const canvas = document.getElementById('plate');
const paint = canvas.getContext('2d');
const grabRadius = 9;
const colours = { walkable: '#4cd07d', obstacle: '#ff7a6b', wall: '#6aa8ff', cutout: '#ffd166' };
const pixelsOf = { point: 1, height: 2, line_x: 2, line_y: 2, line_z: 2, shadow: 3, distance: 2, standing: 2 };
let view = { scale: 1, x: 0, y: 0 };   // from the photo's pixels to the canvas'
let cursor = null;                     // of the keyboard
let drag = null;

const toCanvas = ([u, v]) => [(u + 0.5) * view.scale + view.x, (v + 0.5) * view.scale + view.y];
const toPhoto = ([x, y]) => [(x - view.x) / view.scale - 0.5, (y - view.y) / view.scale - 0.5];
const rounded = (px) => px.map((value) => Math.round(value * 10) / 10);

/** From now on clicks are of this view, drawn or not. */
function look(next) {
  view = next;
  canvas.dataset.view = JSON.stringify(view);
  drawSoon();
}

function fit() {
  if (!plate.photo) return;
  const [width, height] = plate.photo.size;
  const scale = Math.min(canvas.clientWidth / width, canvas.clientHeight / height);
  look({ scale, x: (canvas.clientWidth - width * scale) / 2, y: (canvas.clientHeight - height * scale) / 2 });
}

function zoomAt([x, y], factor) {
  const scale = Math.min(Math.max(view.scale * factor, 0.02), 40);
  const ratio = scale / view.scale;
  look({ scale, x: x - (x - view.x) * ratio, y: y - (y - view.y) * ratio });
}

// Clicks

/** What the tool makes of the pixels that it asked for. */
function finish(tool, px) {
  change({ drawing: [] });
  if (tool === 'point') changeClicks({ points: [...plate.points, { px: px[0], m: null }] });
  else if (tool === 'height') changeClicks({ heights: [...plate.heights, { foot_px: px[0], head_px: px[1], height_m: 1.75 }] });
  else if (tool.startsWith('line_')) changeClicks({ lines: [...plate.lines, { axis: tool.at(-1), from_px: px[0], to_px: px[1] }] });
  else if (tool === 'shadow') shadowClicked(px);
  else if (tool === 'distance' || tool === 'standing') change({ measured: [...plate.measured, { kind: tool, px }] });
  else change({ shapes: [...plate.shapes, { kind: tool, px, ...(kinds[tool].height_m ? { height_m: kinds[tool].height_m } : {}) }] });
}

function click(px) {
  if (!plate.photo || plate.tool === 'figure') {
    if (plate.found) change({ figure: { px } });
    return;
  }
  const drawing = [...plate.drawing, rounded(px)];
  const [first] = plate.drawing;
  const near = first && Math.hypot(...toCanvas(first).map((value, i) => value - toCanvas(px)[i])) < grabRadius;
  if (kinds[plate.tool] && plate.tool !== 'cutout' && near && plate.drawing.length >= kinds[plate.tool].least) done();
  else if (drawing.length === pixelsOf[plate.tool]) finish(plate.tool, drawing);
  else change({ drawing });
}

/** Ends a shape that has as many corners as somebody likes. */
export function done() {
  if (plate.drawing.length >= (kinds[plate.tool]?.least ?? Infinity)) finish(plate.tool, plate.drawing);
}

// Drawing

function path(pixels, isClosed) {
  paint.beginPath();
  pixels.forEach((px, index) => (index ? paint.lineTo(...toCanvas(px)) : paint.moveTo(...toCanvas(px))));
  if (isClosed) paint.closePath();
}

function stroke(pixels, colour, isClosed = false, width = 1.6) {
  path(pixels, isClosed);
  // Dark below, so that it is seen on any photo.
  paint.strokeStyle = '#000a';
  paint.lineWidth = width + 1.6;
  paint.stroke();
  paint.strokeStyle = colour;
  paint.lineWidth = width;
  paint.stroke();
}

function drawGrid({ columns, px }) {
  paint.beginPath();
  const line = (one, other) => {
    if (!one || !other) return;
    paint.moveTo(...toCanvas(one));
    paint.lineTo(...toCanvas(other));
  };
  px.forEach((at, index) => {
    if ((index + 1) % columns) line(at, px[index + 1]);
    line(at, px[index + columns]);
  });
  paint.strokeStyle = '#5cc8ff8c';
  paint.lineWidth = 1;
  paint.stroke();
}

function fill(pixels, colour) {
  if (pixels.length < 3 || pixels.includes(null)) return;
  path(pixels, true);
  paint.fillStyle = colour;
  paint.fill();
}

function mark([u, v], label, isBad) {
  const [x, y] = toCanvas([u, v]);
  stroke([toPhoto([x - 7, y]), toPhoto([x + 7, y])], isBad ? '#ff5544' : '#fff');
  stroke([toPhoto([x, y - 7]), toPhoto([x, y + 7])], isBad ? '#ff5544' : '#fff');
  if (isBad) { paint.beginPath(); paint.arc(x, y, 12, 0, 7); paint.strokeStyle = '#ff5544'; paint.lineWidth = 3; paint.stroke(); }
  paint.font = '12px system-ui, sans-serif';
  paint.lineWidth = 3;
  paint.strokeStyle = '#000c';
  paint.strokeText(label, x + 9, y - 6);
  paint.fillStyle = '#fff';
  paint.fillText(label, x + 9, y - 6);
}

const edges = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

function drawShapes() {
  plate.shapes.forEach((shape, index) => {
    const isBad = plate.problem?.of === `shapes[${index}]`;
    const pixels = shape.kind === 'cutout' ? shape.px.slice(0, -1) : shape.px;
    if (shape.kind !== 'wall') fill(pixels, colours[shape.kind] + '38');
    stroke(pixels, isBad ? '#ff5544' : colours[shape.kind], shape.kind !== 'wall');
    if (shape.kind === 'cutout') mark(shape.px.at(-1), 'foot', isBad);
  });
  for (const corners of plate.shown.cuboids ?? [])
    for (const [from, to] of edges) if (corners[from] && corners[to]) stroke([corners[from], corners[to]], '#ffffffb0', false, 1);
}

function drawClicks() {
  plate.heights.forEach(({ foot_px: foot, head_px: top, height_m: height }, index) => {
    stroke([foot, top], '#ffb454');
    mark(foot, `${height} m`, plate.problem?.of === `heights[${index}]`);
  });
  plate.lines.forEach(({ axis, from_px: from, to_px: to }, index) => {
    stroke([from, to], { x: '#ff7a6b', y: '#4cd07d', z: '#6aa8ff' }[axis]);
    mark(from, axis, plate.problem?.of === `lines[${index}]`);
  });
  plate.points.forEach(({ px }, index) => {
    const residual = plate.isStale ? undefined : plate.found?.residuals?.find((one) => one.of === `points[${index}]`);
    // Ten times as long as it is, or nobody would see it.
    if (residual) stroke([px, px.map((value, i) => value - 10 * residual.off_px[i])], '#ff5cf0');
    mark(px, String(index + 1), plate.problem?.of === `points[${index}]`);
  });
}

function drawMeasured() {
  plate.measured.forEach(({ px }, index) => {
    stroke(px, '#5cf0d8');
    mark(px[0], '', false);
    mark(px[1], textOf(plate.shown.metres?.[index]), false);
  });
}

function draw() {
  const ratio = devicePixelRatio;
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  paint.setTransform(ratio, 0, 0, ratio, 0, 0);
  paint.clearRect(0, 0, width, height);
  if (!plate.photo) return;
  const [x, y] = toCanvas([-0.5, -0.5]);
  paint.imageSmoothingEnabled = view.scale < 3;
  paint.drawImage(plate.photo.bitmap, x, y, plate.photo.size[0] * view.scale, plate.photo.size[1] * view.scale);
  const { grid, body = [], shadow = [], standing = [] } = plate.shown;
  if (grid && document.getElementById('grid').checked) drawGrid(grid);
  drawShapes();
  fill(shadow, '#0009');
  fill(body, '#ffb454d9');
  drawClicks();
  drawMeasured();
  if (plate.drawing.length) stroke(plate.drawing, colours[plate.tool] ?? '#fff');
  plate.drawing.forEach((px) => mark(px, '', false));
  if (cursor && document.activeElement === canvas) mark(cursor, rounded(cursor).join(', '), false);
  canvas.dataset.standing = JSON.stringify(standing);
  canvas.dataset.place = JSON.stringify(plate.shown.place ?? null);
}

let isDue = false;
function drawSoon() {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(() => { isDue = false; draw(); });
}

// Pointer and keys

const placeOf = (event) => [event.offsetX, event.offsetY];

function grabbed(at) {
  const near = (px) => Math.hypot(...toCanvas(px).map((value, i) => value - at[i]));
  const { body = [], standing } = plate.shown;
  const all = handles().toSorted((one, other) => near(one.px) - near(other.px));
  if (all.length && near(all[0].px) < grabRadius) return all[0].of + '@' + handles().findIndex(({ px }) => px === all[0].px);
  if (body.length && !body.includes(null) && standing[0]) {
    path(body, true);
    if (paint.isPointInPath(...at.map((value) => value * devicePixelRatio)) || near(standing[0]) < grabRadius) return 'figure';
  }
  return null;
}

canvas.addEventListener('pointerdown', (event) => {
  if (event.button !== 0 || !plate.photo) return;
  canvas.setPointerCapture(event.pointerId);
  const at = placeOf(event);
  const of = grabbed(at);
  const from = of === 'figure' ? plate.shown.standing[0] : null;
  drag = { of, from: at, last: at, moved: false, offset: from ? toPhoto(at).map((value, i) => value - from[i]) : [0, 0] };
});
canvas.addEventListener('pointermove', (event) => {
  if (!drag) return;
  const at = placeOf(event);
  if (!drag.moved && Math.hypot(at[0] - drag.from[0], at[1] - drag.from[1]) < 4) return;
  drag.moved = true;
  const px = toPhoto(at).map((value, i) => value - drag.offset[i]);
  if (drag.of === 'figure') {
    change({ figure: { px } });
  } else if (drag.of) {
    handles()[Number(drag.of.split('@')[1])].move(rounded(px));
  } else {
    look({ ...view, x: view.x + at[0] - drag.last[0], y: view.y + at[1] - drag.last[1] });
  }
  drag.last = at;
});
canvas.addEventListener('pointerup', (event) => {
  const was = drag;
  drag = null;
  if (was && !was.moved) click(toPhoto(placeOf(event)));
});
canvas.addEventListener('pointercancel', () => { drag = null; });
canvas.addEventListener('wheel', (event) => {
  event.preventDefault();
  zoomAt(placeOf(event), 1.1 ** (-event.deltaY / 100));
}, { passive: false });

const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
canvas.addEventListener('keydown', (event) => {
  if (!plate.photo) return;
  cursor ??= plate.photo.size.map((side) => Math.floor(side / 2));
  const step = steps[event.key];
  if (step) cursor = cursor.map((value, i) => Math.min(Math.max(value + step[i] * (event.shiftKey ? 1 : 10), 0), plate.photo.size[i] - 1));
  else if (event.key === ' ') click(cursor);
  else if (event.key === 'Enter') done();
  else if (event.key === 'Escape') change({ drawing: [] });
  else if (event.key === '+' || event.key === '-') zoomAt(toCanvas(cursor), event.key === '+' ? 1.25 : 0.8);
  else return;
  event.preventDefault();
  drawSoon();
});
canvas.addEventListener('focus', drawSoon);
canvas.addEventListener('blur', drawSoon);
document.getElementById('grid').addEventListener('change', drawSoon);
document.getElementById('zoom-in').addEventListener('click', () => zoomAt([canvas.clientWidth / 2, canvas.clientHeight / 2], 1.25));
document.getElementById('zoom-out').addEventListener('click', () => zoomAt([canvas.clientWidth / 2, canvas.clientHeight / 2], 0.8));
document.getElementById('zoom-fit').addEventListener('click', fit);
new ResizeObserver(fit).observe(canvas);

let fitted = null;
listen(() => {
  if (fitted !== plate.photo) {
    fitted = plate.photo;
    cursor = null;
    fit();
  }
  drawSoon();
});
