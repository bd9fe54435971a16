// World time: runs, stands still, goes by steps.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { listen, state } from './state.js';

const run = document.getElementById('run');
const step = document.getElementById('step');
const seconds = document.getElementById('step-seconds');
const clock = document.getElementById('clock');
const rig = document.getElementById('rig');

run.addEventListener('click', () => attempt(async () => {
  state.world = await call(state.world?.paused ? 'world.resume' : 'world.pause');
  show();
}));
step.addEventListener('click', () => attempt(async () => {
  step.disabled = true;
  try {
    state.world = await call('world.step', { seconds: Number(seconds.value) });
  } finally {
    step.disabled = false;
  }
  show();
}));

function show() {
  const { world, info, connected } = state;
  document.body.classList.toggle('lost', !connected);
  rig.textContent = connected ? `${info.renderer} · camrig ${info.version}` : `no answer from the rig${state.problem ? ': ' + state.problem : ''}`;
  if (!world) return;
  const lockstep = world.mode === 'lockstep';
  document.getElementById('scene').textContent = `${world.scene} · ${world.mode}`;
  const total = world.world_ns / 1e9;
  clock.textContent = `${String(Math.floor(total / 60)).padStart(2, '0')}:${(total % 60).toFixed(2).padStart(5, '0')}`;
  run.textContent = world.paused ? 'Play' : 'Pause';
  run.hidden = lockstep;
  step.disabled = !lockstep && !world.paused;
  step.title = step.disabled ? 'Pause first' : '';
}
listen(show);
