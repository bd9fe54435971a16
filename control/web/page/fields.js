// Pose and picture by numbers and words; most fields are those that the rig describes. A field that is being edited is left alone until it is done,
// or another camera is chosen.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { adopt, listen, selectedCamera } from './state.js';

const form = document.getElementById('fields');
const place = (index) => (camera, value) => ({ pose: { ...angles(camera), position: camera.pose.position.with(index, value) } });
const angle = (key) => (camera, value) => ({ pose: { ...angles(camera), [key]: value } });

function angles({ pose }) {
  return { position: pose.position, pan_deg: pose.pan_deg, tilt_deg: pose.tilt_deg, roll_deg: pose.roll_deg };
}
function numberOf(text) {
  const value = Number(text);
  if (text.trim() === '' || !Number.isFinite(value)) throw new Error(`'${text}' is not a number`);
  return value;
}
const rounded = (value, digits) => String(Number(value.toFixed(digits)));

// Those with a form of their own: label, what it shows, what it asks for.
const ownFields = [
  ['x (m)', (c) => rounded(c.pose.position[0], 3), place(0)],
  ['y (m)', (c) => rounded(c.pose.position[1], 3), place(1)],
  ['z (m)', (c) => rounded(c.pose.position[2], 3), place(2)],
  ['Pan (°)', (c) => rounded(c.pose.pan_deg, 2), angle('pan_deg')],
  ['Tilt (°)', (c) => rounded(c.pose.tilt_deg, 2), angle('tilt_deg')],
  ['Roll (°)', (c) => rounded(c.pose.roll_deg, 2), angle('roll_deg')],
  ['Vertical view (°)', (c) => rounded(c.vfov_deg, 2), (c, value) => ({ vfov_deg: value, zoom: c.zoom })],
  ['Frames/s', (c) => String(c.fps), (c, value, text) => ({ fps: text.includes('/') ? text.trim() : value })],
  ['Width', (c) => String(c.size[0]), (c, value) => ({ size: [value, c.size[1]] })],
  ['Height', (c) => String(c.size[1]), (c, value) => ({ size: [c.size[0], value] })],
];
const shownAbove = new Set(['name', 'fps', 'vfov_deg', 'size', 'pose']);
// They are what they are at the zoom that is given with them.
const optics = new Set(['hfov_deg', 'intrinsics']);

async function set(wish) {
  const { name } = selectedCamera();
  const answered = await attempt(() => call('camera.set', { name, ...wish }));
  if (answered) adopt(answered);
  else showAll();  // what was refused is put back
}

// All controls: the element, and what it shows of a camera. Parts of what may be null: the element, and whether the camera has it.
const shown = [];
const optional = [];
let shownName = null;  // of the camera that they show
/** What is typed or chosen is for the camera that was shown meanwhile, and for no other. */
const isForSelected = () => selectedCamera()?.name === shownName;

function add(parent, label, element, read) {
  const holder = document.createElement('label');
  holder.append(label + ' ', element);
  parent.append(holder);
  shown.push({ element, read });
}

function addText(parent, label, read, wishOf) {
  const input = document.createElement('input');
  input.spellcheck = false;
  input.addEventListener('change', () => attempt(async () => {
    if (!isForSelected()) return;
    const wish = wishOf(selectedCamera(), input.value);
    input.blur();
    await set(wish);
  }));
  add(parent, label, input, read);
  return input;
}

function addChoice(parent, label, words, read, wishOf) {
  const choice = document.createElement('select');
  for (const word of words) choice.add(new Option(word));
  choice.addEventListener('change', () => {
    if (!isForSelected()) return;
    choice.blur();
    const wish = wishOf(choice.value);
    if (wish) set(wish);
    else showAll();
  });
  add(parent, label, choice, read);
}

const labelOf = ({ name, label = name.replaceAll('_', ' '), unit }) => label[0].toUpperCase() + label.slice(1) + (unit ? ` (${unit})` : '');

/** A value as people read it: lists with spaces, objects with the names of their parts. */
function textOf(value) {
  if (value == null) return '';
  if (typeof value === 'number') return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(6)));
  if (Array.isArray(value)) return value.map(textOf).join(value.some((one) => typeof one === 'object') ? '; ' : ' ');
  if (typeof value === 'object') return Object.entries(value).map(([name, part]) => `${name.replaceAll('_', ' ')} ${textOf(part)}`).join(', ');
  return String(value);
}

// Of objects that are whole and may be null: those of the camera that is shown that a person has opened to fill in, while they are null.
const begun = new Set();

/** An object: its parts, each with a control. One that is whole is sent with all its parts. */
function addObject(parent, field, read, wish) {
  const part = document.createElement('fieldset');
  const legend = document.createElement('legend');
  legend.textContent = labelOf(field);
  part.append(legend);
  parent.append(part);
  let parts = part;
  if (field.null) {
    // It is switched on with its defaults, or, where it must be told something, once that is; its parts are there while it is.
    const isThere = (c) => read(c) != null || begun.has(field);
    addChoice(part, labelOf(field), [field.null, 'on'], (c) => (isThere(c) ? 'on' : field.null), (word) => {
      if (word === 'on' && field.whole) begun.add(field); else begun.delete(field);
      return word !== 'on' ? wish(null) : field.whole ? null : wish({});
    });
    parts = part.appendChild(document.createElement('fieldset'));
    optional.push({ element: parts, isThere });
  }
  for (const inner of field.fields) {
    if (inner.by === 'client') continue;
    const rest = () => (field.whole ? read(selectedCamera()) : {});
    addDescribed(parts, inner, (c) => read(c)?.[inner.name], (value) => wish({ ...rest(), [inner.name]: value }));
  }
}

/** A field as the rig describes it (server.describe): `read` its value of a camera, `wish` for it. What may be null is empty then; what the rig sets, and
 * what has no control here, is text. */
function addDescribed(parent, field, read, wish) {
  const label = labelOf(field);
  const type = field.type.replace(' or null', '');
  const orNull = (parse) => (c, text) => wish(field.null && text.trim() === '' ? null : parse(text));
  if (field.by === 'rig') {
    add(parent, label, document.createElement('output'), (c) => textOf(read(c)));
  } else if (type === 'boolean') {
    addChoice(parent, label, ['off', 'on'], (c) => (read(c) ? 'on' : 'off'), (word) => wish(word === 'on'));
  } else if (field.choices) {
    const words = field.null ? [field.null, ...field.choices] : field.choices;
    addChoice(parent, label, words, (c) => read(c) ?? field.null, (word) => wish(field.null === word ? null : word));
  } else if (type.startsWith('number') || type === 'integer') {
    const input = addText(parent, label, (c) => textOf(read(c)), orNull((text) => (text === field.word ? text : numberOf(text))));
    input.placeholder = field.null ?? '';
    if (!field.word) input.inputMode = 'decimal';
  } else if (type === 'array of numbers') {
    const input = addText(parent, label, (c) => (read(c) ?? []).map(textOf).join(' '), orNull((text) => text.trim().split(/[\s,]+/).map(numberOf)));
    input.placeholder = field.null ?? '';
  } else if (type === 'string') {
    addText(parent, label, (c) => read(c) ?? '', (c, text) => wish(text));
  } else if (type === 'object' && field.fields) {
    addObject(parent, field, read, wish);
  } else {
    add(parent, label, document.createElement('output'), (c) => textOf(read(c)));
  }
}

for (const [label, read, ask] of ownFields) {
  const valueOf = (text) => (text.includes('/') && label === 'Frames/s' ? 0 : numberOf(text));
  addText(form, label, read, (camera, text) => ask(camera, valueOf(text), text)).inputMode = 'decimal';
}

function showAll() {
  const camera = selectedCamera();
  for (const control of form.elements) control.disabled = !camera;
  if (!camera) return;
  if (!isForSelected()) {
    if (form.contains(document.activeElement)) document.activeElement.blur();
    begun.clear();
  }
  shownName = camera.name;
  for (const { element, isThere } of optional) element.hidden = !isThere(camera);
  for (const { element, read } of shown) {
    const text = read(camera) ?? '';
    if (document.activeElement !== element && element.value !== text) element.value = text;
  }
}
form.addEventListener('submit', (event) => { event.preventDefault(); document.activeElement?.blur(); });
listen(showAll);

attempt(async () => {
  const { objects } = await call('server.describe');
  for (const field of objects.camera) {
    if (field.by === 'client' || shownAbove.has(field.name)) continue;
    const zoom = () => (optics.has(field.name) ? { zoom: selectedCamera().zoom } : {});
    addDescribed(form, field, (c) => c[field.name], (value) => ({ [field.name]: value, ...zoom() }));
  }
  showAll();
});
