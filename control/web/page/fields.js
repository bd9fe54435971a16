// Pose and picture by numbers. A field that is being edited is left alone until it is done.
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

// label, what it shows, what it asks for
const fields = [
  ['x (m)', (c) => rounded(c.pose.position[0], 3), place(0)],
  ['y (m)', (c) => rounded(c.pose.position[1], 3), place(1)],
  ['z (m)', (c) => rounded(c.pose.position[2], 3), place(2)],
  ['Pan (°)', (c) => rounded(c.pose.pan_deg, 2), angle('pan_deg')],
  ['Tilt (°)', (c) => rounded(c.pose.tilt_deg, 2), angle('tilt_deg')],
  ['Roll (°)', (c) => rounded(c.pose.roll_deg, 2), angle('roll_deg')],
  ['Vertical view (°)', (c) => rounded(c.vfov_deg, 2), (c, value) => ({ vfov_deg: value, zoom: c.zoom })],
  ['Zoom', (c) => rounded(c.zoom, 2), (c, value) => ({ zoom: value })],
  ['Frames/s', (c) => String(c.fps), (c, value, text) => ({ fps: text.includes('/') ? text.trim() : value })],
  ['Width', (c) => String(c.size[0]), (c, value) => ({ size: [value, c.size[1]] })],
  ['Height', (c) => String(c.size[1]), (c, value) => ({ size: [c.size[0], value] })],
];

async function set(wish) {
  const { name } = selectedCamera();
  const answered = await attempt(() => call('camera.set', { name, ...wish }));
  if (answered) adopt(answered);
  else showAll();  // what was refused is put back
}

const inputs = fields.map(([label, , ask]) => {
  const holder = document.createElement('label');
  holder.append(label + ' ');
  const input = document.createElement('input');
  input.inputMode = 'decimal';
  input.spellcheck = false;
  input.addEventListener('change', () => attempt(async () => {
    const text = input.value;
    const value = text.includes('/') && label === 'Frames/s' ? 0 : numberOf(text);
    input.blur();
    await set(ask(selectedCamera(), value, text));
  }));
  holder.append(input);
  form.append(holder);
  return input;
});

function addChoice(label, options, read, ask) {
  const holder = document.createElement('label');
  holder.append(label + ' ');
  const choice = document.createElement('select');
  for (const option of options) choice.add(new Option(option));
  choice.addEventListener('change', () => { choice.blur(); set(ask(choice.value)); });
  holder.append(choice);
  form.append(holder);
  return { choice, read };
}
const choices = [
  addChoice('Quality', ["the rig's", 'fast', 'simple', 'beautiful'], (c) => c.quality ?? "the rig's", (value) => ({ quality: value === "the rig's" ? null : value })),
  addChoice('Antialias', ['auto', 'none', 'msaa4', 'ssaa2', 'ssaa3', 'ssaa4'], (c) => c.antialias, (value) => ({ antialias: value })),
  addChoice('Code strip', ['off', 'on'], (c) => (c.code_strip ? 'on' : 'off'), (value) => ({ code_strip: value === 'on' })),
];

function showAll() {
  const camera = selectedCamera();
  for (const control of form.elements) control.disabled = !camera;
  if (!camera) return;
  fields.forEach(([, read], index) => {
    const text = read(camera);
    if (document.activeElement !== inputs[index] && inputs[index].value !== text) inputs[index].value = text;
  });
  for (const { choice, read } of choices) if (document.activeElement !== choice && choice.value !== read(camera)) choice.value = read(camera);
}
form.addEventListener('submit', (event) => { event.preventDefault(); document.activeElement?.blur(); });
listen(showAll);
