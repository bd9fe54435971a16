// What happens in the world: a live feed, rules that make it happen, and events of the user's own.
import { call } from './rpc.js';
import { attempt } from './messages.js';
import { listen, state } from './state.js';

const mostShown = 200;
const waitSeconds = 25;
const feed = document.getElementById('feed');
const rules = document.getElementById('rules');
const fire = document.getElementById('fire');
const add = document.getElementById('add-event');
let since = null;  // number of the newest event in the feed; null: the feed is to be made anew
let shownRules = '';

function parse(field) {
  try {
    return JSON.parse(field.value);
  } catch (problem) {
    field.focus();
    throw new Error(`${field.name}: this is not JSON (${problem.message})`);
  }
}

function lineOf(event) {
  const line = document.createElement('li');
  const time = document.createElement('time');
  time.textContent = (event.world_ns / 1e9).toFixed(2);
  const name = document.createElement('b');
  name.textContent = event.event;
  const about = [event.actor, ...event.data.map((one) => JSON.stringify(one)), ...event.errors].filter(Boolean).join(' · ');
  line.append(time, ' ', name, ' ', about);
  if (event.errors.length) line.className = 'error';
  return line;
}

/** Waits for events until the signal says that the page is hidden. */
export async function keepWaiting(signal) {
  while (!signal.aborted) {
    try {
      const isAnew = since === null;
      const news = await call('event.wait', isAnew ? { timeout_s: 0 } : { since, timeout_s: waitSeconds }, signal);
      if (isAnew) feed.replaceChildren();
      feed.prepend(...news.events.slice(-mostShown).reverse().map(lineOf));
      while (feed.children.length > mostShown) feed.lastChild.remove();
      since = !isAnew && news.last < since ? null : news.last;  // fewer than before: another rig
    } catch (problem) {
      if (signal.aborted) return;
      since = null;
      await new Promise((next) => setTimeout(next, 1000));
    }
  }
}

/** Rules are for times to come: when the world runs on meanwhile, a little later is tried. */
async function fireSoon(name, rest) {
  for (const ahead of [0.05, 0.5, 3]) {
    const { world_ns } = await call('world.status');
    try {
      return await call('event.add', { name, when: { at_s: world_ns / 1e9 + ahead }, ...rest });
    } catch (problem) {
      if (problem.kind !== 'invalid_argument' || ahead === 3) throw problem;
    }
  }
  return undefined;
}

// An event of the user's is a rule for this very moment; the last one of the same name has had its moment.
fire.addEventListener('submit', (event) => {
  event.preventDefault();
  attempt(async () => {
    const name = fire.elements.name.value.trim();
    const data = fire.elements.data.value.trim() ? parse(fire.elements.data) : null;
    const known = (await call('event.list')).events.find((one) => one.name === name);
    if (known && known.when === 'at_s' && known.limit === 1 && known.fired === 1) await call('event.remove', { name });
    await fireSoon(name, { limit: 1, do: [{ action: 'user', data }] });
  });
});

add.addEventListener('submit', (event) => {
  event.preventDefault();
  attempt(async () => {
    await call('event.add', { name: add.elements.name.value.trim(), when: parse(add.elements.when), do: parse(add.elements.do) });
    add.elements.name.value = '';
    state.rules = (await call('event.list')).events;
    showRules();
  });
});

function showRules() {
  const key = JSON.stringify(state.rules);
  if (key === shownRules) return;
  shownRules = key;
  document.getElementById('rule-count').textContent = String(state.rules.length);
  rules.replaceChildren(...state.rules.map((rule) => {
    const line = document.createElement('li');
    const name = document.createElement('b');
    name.textContent = rule.name;
    const remove = document.createElement('button');
    remove.type = 'button';
    remove.textContent = 'Remove';
    remove.setAttribute('aria-label', `Remove rule ${rule.name}`);
    remove.addEventListener('click', () => attempt(async () => {
      await call('event.remove', { name: rule.name });
      state.rules = state.rules.filter((one) => one !== rule);
      showRules();
    }));
    line.append(name, ` ${rule.when}, fired ${rule.fired}${rule.limit ? ' of ' + rule.limit : ''} `, remove);
    return line;
  }));
}
listen((_, stage) => { if (stage === 'stats') showRules(); });
