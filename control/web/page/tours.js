// Guard tours of a head (ptz.tour_*): those that it has, and a form that makes one of its presets, each with the time that it stands there.
import { hasHead, onStatus, tellHead } from './head.js';
import { attempt } from './messages.js';
import { call } from './rpc.js';
import { listen, selectedCamera } from './state.js';

const panel = document.getElementById('tours');
const list = document.getElementById('tour-list');
const form = panel.querySelector('form');
const stopList = document.getElementById('tour-stops');
const { name: tourName, preset, dwell } = form.elements;

let stops = [];      // of the tour that is being made: { preset, dwell_s }
let known = '';      // what is listed; the list is made anew only when it changes, so that the focus stays where it is

function button(text, label, run) {
  const one = document.createElement('button');
  one.type = 'button';
  one.textContent = text;
  one.setAttribute('aria-label', label);
  one.addEventListener('click', run);
  return one;
}

const line = (stop) => `${stop.preset} ${Number(stop.dwell_s.toFixed(1))} s`;

function listed(name, stopsOfTour, runs) {
  const item = document.createElement('li');
  const text = document.createElement('span');
  text.textContent = `${name}: ${stopsOfTour.map(line).join(' → ')}`;
  const camera = () => selectedCamera().name;
  item.append(text,
    runs ? button('Stop', `Stop tour ${name}`, () => tellHead(camera(), 'ptz.stop', {}))
      : button('Start', `Start tour ${name}`, () => tellHead(camera(), 'ptz.tour_start', { tour: name })),
    button('Remove', `Remove tour ${name}`, () => tellHead(camera(), 'ptz.tour_remove', { tour: name })));
  if (runs) item.setAttribute('aria-current', 'true');
  return item;
}

function showStops() {
  stopList.replaceChildren(...stops.map((stop, index) => {
    const item = document.createElement('li');
    const text = document.createElement('span');
    text.textContent = line(stop);
    item.append(text, button('×', `Leave out stop ${index + 1}`, () => { stops.splice(index, 1); showStops(); }));
    return item;
  }));
  form.querySelector('[data-make]').disabled = stops.length === 0;
}

onStatus((status) => {
  const now = JSON.stringify([selectedCamera().name, status.tours, status.tour, Object.keys(status.presets)]);
  if (now === known) return;
  known = now;
  list.replaceChildren(...Object.entries(status.tours).map(([name, one]) => listed(name, one, name === status.tour)));
  const chosen = preset.value;
  const names = Object.keys(status.presets);
  preset.replaceChildren(...names.map((one) => new Option(one, one)));
  if (names.includes(chosen)) preset.value = chosen;
  form.querySelector('[data-add]').disabled = names.length === 0;
});

listen((_, stage) => {
  panel.hidden = !hasHead(selectedCamera());
  if (stage !== 'selected') return;
  stops = [];
  known = '';
  list.replaceChildren();
  showStops();
});

form.querySelector('[data-add]').addEventListener('click', () => {
  if (!dwell.reportValidity()) return;
  stops.push({ preset: preset.value, dwell_s: Number(dwell.value) });
  showStops();
});
form.addEventListener('submit', async (event) => {
  event.preventDefault();
  const sent = stops;
  const made = await attempt(() => call('ptz.tour_set', { camera: selectedCamera().name, tour: tourName.value.trim(), stops: sent }));
  if (!made || stops !== sent) return;  // what was refused may be mended; another camera has a form of its own
  tourName.value = '';
  stops = [];
  showStops();
});
