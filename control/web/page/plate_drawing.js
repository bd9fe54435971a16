// The tools, and the shapes that were drawn, each with its height, its role and its corners by numbers.
import { done } from './plate_picture.js';
import { hasRole, kinds, roles } from './plate_shapes.js';
import { change, listen, plate, withOne } from './plate_state.js';

const tools = document.getElementById('tools');
const holder = document.getElementById('shapes');
const hints = {
  point: 'Click a point whose place you know, and give its metres on the right; marks can be dragged.',
  height: 'Click the foot and the head of something upright of a known height.',
  line_x: 'Click two places on an edge along x.', line_y: 'Click two places on an edge along y.', line_z: 'Click two places on an upright edge.',
  figure: 'Drag the figure about, or click where it shall stand.',
  distance: 'Click two places on the ground: how far they are apart is told.',
  standing: 'Click the foot and the head of something upright: how tall it is is told.',
  shadow: 'Click the top and the foot of something upright, and the tip of its shadow.',
  ...Object.fromEntries(Object.entries(kinds).map(([kind, { label, hint }]) => [kind, `${label}: click ${hint}; then Done.`])),
};

tools.addEventListener('change', ({ target }) => change({ tool: target.value, drawing: [] }));
document.getElementById('done').addEventListener('click', done);
document.getElementById('undo').addEventListener('click', () => change({ drawing: plate.drawing.slice(0, -1) }));

/** The choices of what a shape does. */
const roleOptions = () => Object.entries(roles).map(([role, text]) => new Option(text, role));

const groundRole = document.getElementById('ground-role');
groundRole.append(...roleOptions());
groundRole.addEventListener('change', () => change({ groundRole: groundRole.value }));

const rows = [];

function makeRow(index) {
  const row = document.createElement('li');
  const name = document.createElement('b');
  const height = document.createElement('input');
  height.type = 'number';
  height.min = '0.01';
  height.step = 'any';
  height.setAttribute('aria-label', `Height of shape ${index + 1} (m)`);
  const set = (values) => change({ shapes: withOne(plate.shapes, index, { ...plate.shapes[index], ...values }), problem: null });
  height.addEventListener('change', () => {
    const value = Number(height.value);
    if (value > 0 && value <= 1e4) set({ height_m: value });
    else change({ problem: { of: `shapes[${index}]`, text: 'its height must be over 0 and at most 10000 m' } });
  });
  const role = document.createElement('select');
  role.append(...roleOptions());
  role.setAttribute('aria-label', `Role of shape ${index + 1}`);
  role.addEventListener('change', () => set({ role: role.value }));
  const corners = document.createElement('input');
  corners.spellcheck = false;
  corners.setAttribute('aria-label', `Corners of shape ${index + 1} (px)`);
  corners.addEventListener('change', () => {
    const px = corners.value.trim().split(/\s+/).map((pair) => pair.split(',').map(Number));
    const { least } = kinds[plate.shapes[index].kind];
    if (px.length >= least && px.every((pair) => pair.length === 2 && pair.every(Number.isFinite))) set({ px });
    else change({ problem: { of: `shapes[${index}]`, text: `give at least ${least} corners, as 12,340 56,340 ...` } });
  });
  const remove = document.createElement('button');
  remove.type = 'button';
  remove.textContent = '×';
  remove.setAttribute('aria-label', `Remove shape ${index + 1}`);
  remove.addEventListener('click', () => change({ shapes: withOne(plate.shapes, index, undefined), problem: null }));
  const problem = document.createElement('p');
  problem.className = 'problem';
  row.append(name, height, role, corners, remove, problem);
  holder.append(row);
  return { row, name, height, role, corners, problem };
}

/** What is wrong with a shape where it lies: corners over the horizon. */
function wrongWith(index) {
  const over = plate.shown.ground?.[index]?.indexOf(null) ?? -1;
  if (over < 0) return '';
  return `${plate.shapes[index].kind === 'cutout' ? 'its foot' : `corner ${over + 1}`} is over the horizon of the ground`;
}

listen(({ tool, drawing, shapes, problem, found, photo }) => {
  document.getElementById('tool-hint').textContent = hints[tool];
  document.getElementById('done').disabled = !(drawing.length >= (kinds[tool]?.least ?? Infinity));
  document.getElementById('undo').disabled = drawing.length === 0;
  const ground = photo?.camera?.backdrop.proxies.ground ?? found?.ground;
  groundRole.disabled = !ground;
  groundRole.value = plate.groundRole ?? ground?.role ?? 'both';
  while (rows.length > shapes.length) rows.pop().row.remove();
  while (rows.length < shapes.length) rows.push(makeRow(rows.length));
  rows.forEach((row, index) => {
    const shape = shapes[index];
    row.name.textContent = kinds[shape.kind].label;
    row.height.hidden = shape.height_m === undefined;
    if (document.activeElement !== row.height) row.height.value = shape.height_m ?? '';
    row.role.hidden = !hasRole(shape);
    row.role.value = shape.role ?? 'both';
    if (document.activeElement !== row.corners) row.corners.value = shape.px.map((px) => px.join(',')).join(' ');
    row.problem.textContent = problem?.of === `shapes[${index}]` ? problem.text : wrongWith(index);
  });
});
