// The clicks by numbers, what else is known, and what comes out of them. What the rig refuses is said at the row or field that it names.
import { call, RpcError } from './rpc.js';
import { change, changeClicks, listen, plate, withOne } from './plate_state.js';

const known = document.getElementById('known');
const answer = document.getElementById('answer');

function numberOf(text, of) {
  const value = Number(text);
  if (text.trim() === '' || !Number.isFinite(value)) throw new RpcError({ message: `${of}: '${text}' is not a number` });
  return value;
}
const textOf = (value, digits) => String(Number(value.toFixed(digits)));

// Rows: of each list its fields, as label, what it shows, and the member that it makes.
const pixel = (key, label) => [0, 1].map((i) => ({
  label: `${label} ${'uv'[i]} (px)`, read: (one) => textOf(one[key][i], 1), write: (one, value) => ({ ...one, [key]: one[key].with(i, value) }),
}));
const number = (key, label, digits = 3) => ({ label, read: (one) => textOf(one[key], digits), write: (one, value) => ({ ...one, [key]: value }) });
const metres = [0, 1, 2].map((i) => ({
  label: `${'xyz'[i]} (m)`, read: (one) => (one.m?.[i] == null ? '' : textOf(one.m[i], 3)),
  write: (one, value) => ({ ...one, m: (one.m ?? [null, null, 0]).with(i, value) }),
}));
const lists = {
  points: [...pixel('px', 'Point'), ...metres],
  heights: [...pixel('foot_px', 'Foot'), ...pixel('head_px', 'Head'), number('height_m', 'Height (m)')],
  lines: [...pixel('from_px', 'From'), ...pixel('to_px', 'To')],
};

function makeRow(list, index) {
  const row = document.createElement('li');
  const name = document.createElement('b');
  row.append(name);
  const inputs = lists[list].map((field) => {
    const input = document.createElement('input');
    input.inputMode = 'decimal';
    input.title = field.label;
    input.placeholder = field.label.split(' ').at(-2);
    input.setAttribute('aria-label', `${list.slice(0, -1)} ${index + 1}: ${field.label}`);
    input.addEventListener('change', () => {
      try {
        changeClicks({ [list]: withOne(plate[list], index, field.write(plate[list][index], numberOf(input.value, `${list}[${index}]`))) });
      } catch (problem) {
        change({ problem: placed(problem) });
      }
    });
    row.append(input);
    return { input, field };
  });
  const off = document.createElement('output');
  const remove = document.createElement('button');
  remove.type = 'button';
  remove.textContent = '×';
  remove.setAttribute('aria-label', `Remove ${list.slice(0, -1)} ${index + 1}`);
  remove.addEventListener('click', () => changeClicks({ [list]: withOne(plate[list], index, undefined) }));
  const problem = document.createElement('p');
  problem.className = 'problem';
  row.append(off, remove, problem);
  return { row, name, inputs, off, problem };
}

const rows = { points: [], heights: [], lines: [] };

/** How far a click is off; of a height the worse of its two. */
function residualOf(list, index) {
  const all = plate.found?.residuals?.filter(({ of }) => of === `${list}[${index}]` || of.startsWith(`${list}[${index}].`)) ?? [];
  return plate.isStale || all.length === 0 ? '' : `${Math.max(...all.map(({ px }) => px)).toFixed(2)} px`;
}

function showList(list) {
  const holder = document.getElementById(list);
  while (rows[list].length > plate[list].length) rows[list].pop().row.remove();
  while (rows[list].length < plate[list].length) {
    const made = makeRow(list, rows[list].length);
    rows[list].push(made);
    holder.append(made.row);
  }
  rows[list].forEach(({ name, inputs, off, problem }, index) => {
    const one = plate[list][index];
    name.textContent = one.axis ?? String(index + 1);
    for (const { input, field } of inputs) if (document.activeElement !== input) input.value = field.read(one);
    off.textContent = residualOf(list, index);
    showProblem(problem, inputs.map(({ input }) => input), plate.problem?.of === `${list}[${index}]` ? plate.problem.text : '');
  });
}

function showProblem(element, inputs, text) {
  element.textContent = text;
  for (const input of inputs) {
    if (text) input.setAttribute('aria-invalid', 'true');
    else input.removeAttribute('aria-invalid');
  }
}

/** A problem with the place that its message names: "points[2].px: .." is of points[2]. */
export function placed(problem) {
  const [, of = ''] = /^([a-z_0-9]+(?:\[\d+\])?)[^:\s]*: /.exec(problem.message) ?? [];
  return { of, text: problem.message };
}

/** The task as plate.calibrate takes it; what is empty is left out. */
function taskOf() {
  plate.points.forEach(({ m }, index) => {
    if (!m || m.includes(null)) throw new RpcError({ message: `points[${index}].m: give x and y in metres` });
  });
  const { intrinsics, lens: model, coefficients, ...rest } = plate.known;
  const task = { size: plate.photo.size, ...rest };
  if (intrinsics && intrinsics.length !== 4) throw new RpcError({ message: 'intrinsics: give four numbers, fx, fy, cx and cy' });
  if (intrinsics) task.intrinsics = Object.fromEntries(['fx', 'fy', 'cx', 'cy'].map((key, i) => [key, intrinsics[i]]));
  if (coefficients && !model) throw new RpcError({ message: 'lens: choose the one that the coefficients are of' });
  if (model) task.lens = { model, coefficients: coefficients ?? [] };
  for (const list of Object.keys(lists)) if (plate[list].length) task[list] = plate[list];
  return task;
}

/** What a search is of; each is made anew when it changes. */
const basis = () => [plate.photo, plate.points, plate.heights, plate.lines, plate.known];

async function calibrate() {
  await taken;
  const asked = basis();
  // A search takes seconds, in which people click on.
  const hasChanged = () => basis().some((one, index) => one !== asked[index]);
  try {
    const [photo] = asked;
    if (!photo) throw new RpcError({ message: 'choose a photo first' });
    const found = await call('plate.calibrate', taskOf());
    if (plate.photo !== photo) return;
    const [width, height] = photo.size;
    change({ found, isStale: hasChanged(), problem: null, figure: plate.figure ?? { px: [width / 2, height * 0.8] } });
  } catch (problem) {
    if (!hasChanged()) change({ problem: placed(problem) });
  }
}

document.getElementById('calibrate').addEventListener('click', calibrate);
known.addEventListener('submit', (event) => event.preventDefault());
/** Of COLMAP's images.txt the lines of points, which are most of it, are left empty. */
function withoutPoints(name, text) {
  if (name !== 'images.txt') return text;
  return text.split('\n').filter((line) => !line.startsWith('#')).map((line, index) => (index % 2 ? '' : line)).join('\n');
}

const textsOf = async (files) => Object.fromEntries(await Promise.all([...files].map(async (file) => [file.name, withoutPoints(file.name, await file.text())])));

/** What a field says; nothing where it is empty. */
async function valueOf({ type, name, value, checked, files, dataset: { kind } }) {
  if (type === 'checkbox') return checked || undefined;
  if (kind === 'files') return files.length ? textsOf(files) : undefined;
  const text = value.trim();
  if (text === '') return undefined;
  if (kind === 'numbers') return text.split(/[\s,;]+/).map((one) => numberOf(one, name));
  return kind === 'word' ? text : numberOf(text, name);
}

let taken = null;   // what was changed last, while a file is read

async function take(target) {
  try {
    const value = await valueOf(target);
    const { [target.name]: before, ...rest } = plate.known;
    changeClicks({ known: value === undefined ? rest : { ...rest, [target.name]: value } });
  } catch (problem) {
    change({ problem: placed(problem) });
  }
}
known.addEventListener('change', ({ target }) => { taken = take(target); });

function showAnswer() {
  const { found, isStale } = plate;
  document.getElementById('verdict').textContent = !found ? 'Not calibrated yet.' : isStale && found.verdict ? 'Clicks have changed since: calibrate again.' : found.reason ?? 'As the rig has it.';
  answer.hidden = !found;
  if (!found) return;
  const { pose, intrinsics, lens } = found.camera;
  const half = found.half_95;
  const pair = (value, digits, around) => textOf(value, digits) + (around === undefined ? '' : ` ± ${textOf(around, digits)}`);
  const values = {
    'Camera at (m)': pose.position.map((value, i) => pair(value, 2, half?.position[i])).join(', '),
    'Pan, tilt, roll (°)': ['pan_deg', 'tilt_deg', 'roll_deg'].map((key) => pair(pose[key] ?? 0, 2, half?.[key])).join(', '),
    'Focal length (px)': pair(intrinsics.fx, 1, half?.focal_px),
  };
  if (lens && lens.model !== 'pinhole') values.Lens = `${lens.model} ${lens.coefficients.map((value) => textOf(value, 4)).join(' ')}${half?.k1 ? `, k1 ± ${textOf(half.k1, 4)}` : ''}`;
  if (found.rms_px !== undefined) {
    values['Clicks are off by (px)'] = `${textOf(found.rms_px, 2)} rms`;
    const sizes = [[found.person_share_95, (share) => `${textOf(100 * share, 1)} % of their height`], [found.ground_m_95, (m) => `${textOf(m, 2)} m on the ground`]];
    values['People are right within'] = sizes.filter(([value]) => value !== null).map(([value, text]) => text(value)).join(', ') || 'nothing to judge by';
  }
  answer.replaceChildren(...Object.entries(values).flatMap(([label, text]) => {
    const [term, details] = [document.createElement('dt'), document.createElement('dd')];
    term.textContent = label;
    details.textContent = text;
    return [term, details];
  }));
  answer.dataset.camera = JSON.stringify(found.camera);
}

listen(() => {
  for (const list of Object.keys(lists)) showList(list);
  const fields = [...known.elements].filter((one) => one.name);
  for (const input of fields) {
    const isIt = plate.problem?.of === input.name;
    showProblem(known.querySelector(`[data-problem=${input.name}]`), [input], isIt ? plate.problem.text : '');
  }
  const { problem } = plate;
  const hasPlace = problem && (/\[\d+\]$/.test(problem.of) || fields.some(({ name }) => name === problem.of));
  document.getElementById('problem').textContent = !problem ? '' : hasPlace ? `See ${problem.of}.` : problem.text;
  showAnswer();
});
