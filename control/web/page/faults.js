// What a camera does wrong (fault.*): a form that sets a fault of any kind that the rig describes, and those that it has.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { listen, selectedCamera, state } from './state.js';

const panel = document.getElementById('faults');
const list = document.getElementById('fault-list');
const form = panel.querySelector('form');
const { kind, severity, seconds } = form.elements;
const params = document.getElementById('fault-params');

let kinds = null;   // as server.describe tells them
let known = '';     // what is listed; the list is made anew only when it changes, so that the focus stays where it is

function control(field) {
  const element = document.createElement(field.choices ? 'select' : 'input');
  if (field.choices) element.append(...field.choices.map((one) => new Option(one)));
  else if (field.type === 'boolean') Object.assign(element, { type: 'checkbox', checked: field.default === 'true' });
  else Object.assign(element, { type: 'number', step: 'any', min: field.minimum ?? '', max: field.maximum ?? '' });
  if (element.type !== 'checkbox') element.value = field.default ?? '';
  element.dataset.param = field.name;
  element.title = field.doc ?? '';
  const label = document.createElement('label');
  label.append(`${field.label ?? field.name.replaceAll('_', ' ')} `, element);
  return label;
}

function valueOf(element) {
  if (element.type === 'checkbox') return element.checked;
  return element.type === 'number' ? Number(element.value) : element.value;
}

function showParams() {
  const chosen = kinds.find((one) => one.name === kind.value);
  params.replaceChildren(...chosen.fields.map(control));
  kind.title = chosen.doc;
}

async function describe() {
  kinds = [];
  const described = await attempt(() => call('server.describe'));
  if (!described) { kinds = null; return; }
  kinds = described.kinds.fault;
  kind.replaceChildren(...kinds.map((one) => new Option(one.name.replaceAll('_', ' '), one.name)));
  showParams();
}

function listed(fault) {
  const item = document.createElement('li');
  const text = document.createElement('span');
  const until = fault.end_ns === null ? '' : `, until ${(fault.end_ns / 1e9).toFixed(1)} s`;
  text.textContent = `${fault.kind.replaceAll('_', ' ')} ${fault.severity}${until}`;
  const clear = document.createElement('button');
  clear.type = 'button';
  clear.textContent = 'Clear';
  clear.setAttribute('aria-label', `Clear ${fault.kind}`);
  clear.addEventListener('click', () => attempt(() => call('fault.clear', { id: fault.id })));
  item.append(text, clear);
  return item;
}

listen((_, stage) => {
  const camera = selectedCamera();
  panel.hidden = !camera;
  if (camera && kinds === null && state.connected) describe();
  if (stage !== 'stats' && stage !== 'selected') return;
  const faults = state.faults.filter((one) => one.camera === camera?.name);
  const now = JSON.stringify(faults);
  if (now === known) return;
  known = now;
  list.replaceChildren(...faults.map(listed));
  panel.querySelector('summary').textContent = faults.length ? `Faults (${faults.length})` : 'Faults';
});

kind.addEventListener('change', showParams);
document.getElementById('wipe').addEventListener('click', () => attempt(() => call('fault.wipe', { camera: selectedCamera().name })));
form.addEventListener('submit', (event) => {
  event.preventDefault();
  const wish = { camera: selectedCamera().name, kind: kind.value, severity: Number(severity.value), params: {} };
  if (seconds.value !== '') wish.end_s = state.world.world_ns / 1e9 + Number(seconds.value);
  for (const element of params.querySelectorAll('[data-param]')) wish.params[element.dataset.param] = valueOf(element);
  attempt(() => call('fault.set', wish));
});
