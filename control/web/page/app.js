// Puts the page together. A hidden page reads and asks nothing, and so costs the rig nothing.
import './cameras.js';
import './faults.js';
import './fields.js';
import './head.js';
import './tours.js';
import './links.js';
import './map.js';
import './rates.js';
import './steer.js';
import './world.js';
import * as events from './events.js';
import * as stage from './stage.js';
import * as tiles from './tiles.js';
import { keepLooking } from './state.js';

let awake = null;

function wake() {
  if (awake) return;
  awake = new AbortController();
  keepLooking(awake.signal);
  events.keepWaiting(awake.signal);
  stage.show();
  tiles.show();
}

function sleep() {
  awake?.abort();
  awake = null;
  stage.hide();
  tiles.hide();
}

document.addEventListener('visibilitychange', () => (document.hidden ? sleep() : wake()));
if (!document.hidden) wake();
