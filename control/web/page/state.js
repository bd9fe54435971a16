// What the page knows of the rig, asked for at a steady rate while the page is visible, and who wants to hear of it.
import { call, callAll } from './rpc.js';

const lookMs = 250;
const slowEvery = 4;  // statistics and rules: every so many looks
const fast = ['world.status', 'camera.list', 'actor.list'];
const slow = [...fast, 'stats.get', 'event.list', 'fault.list'];

export const state = { info: null, world: null, cameras: [], actors: [], stats: null, rules: [], faults: [], selected: null, connected: false };
const listeners = new Set();
const waitingForLooks = [];
let changes = 0;

/** fn(state, stage): stage names what is new: 'look', 'stats', 'selected', 'connection'. */
export function listen(fn) { listeners.add(fn); }
export function notify(stage) { for (const fn of listeners) fn(state, stage); }

export function selectedCamera() { return state.cameras.find((camera) => camera.name === state.selected) ?? null; }

export function select(name) {
  if (state.selected === name) return;
  state.selected = name;
  notify('selected');
}

/** Takes in what a camera.set or camera.create answered, before the next look brings it. */
export function adopt(camera) {
  changes += 1;
  const index = state.cameras.findIndex((one) => one.name === camera.name);
  if (index < 0) state.cameras = [...state.cameras, camera];
  else state.cameras = state.cameras.with(index, camera);
  notify('look');
}

/** When what the rig has now is known: after the look that may be under way, and one more. */
export async function upToDate() {
  for (let looks = 0; looks < 2; looks += 1) await new Promise((next) => waitingForLooks.push(next));
}

async function look(count, signal) {
  const changesBefore = changes;
  if (!state.info) state.info = await call('server.info', {}, signal);
  const found = await callAll(count % slowEvery === 0 ? slow : fast, signal);
  state.world = found['world.status'];
  // A change of ours that was answered while this look was on its way is newer than the look.
  if (changes === changesBefore) state.cameras = found['camera.list'].cameras;
  state.actors = found['actor.list'].actors;
  if (!selectedCamera()) select(state.cameras[0]?.name ?? null);
  notify('look');
  for (const next of waitingForLooks.splice(0)) next();
  if (!found['stats.get']) return;
  state.stats = found['stats.get'];
  state.rules = found['event.list'].events;
  state.faults = found['fault.list'].faults;
  notify('stats');
}

/** Looks until the signal says that the page is hidden. */
export async function keepLooking(signal) {
  for (let count = 0; !signal.aborted; count += 1) {
    const was = state.connected;
    try {
      await look(count, signal);
      state.connected = true;
    } catch (problem) {
      if (signal.aborted) return;
      state.connected = false;
      state.problem = problem.message;
      state.info = null;
    }
    if (was !== state.connected) notify('connection');
    await new Promise((next) => setTimeout(next, state.connected ? lookMs : 4 * lookMs));
  }
}
