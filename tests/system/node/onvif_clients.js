// npm `onvif` and `node-onvif`, unmodified, with the camera of a running rig that has its ONVIF device at PORT of this machine: onvif_clients.js PORT [USER PASSWORD].
// Prints a line of JSON for each; ends with 1 at the first answer that is not what it should be. Nobody else may move the head.
'use strict';
const assert = require('node:assert');
const { promisify } = require('node:util');
const { Cam } = require('onvif');
const { OnvifDevice } = require('node-onvif');

const [port, user = 'camrig', password = 'none'] = process.argv.slice(2);
const wait = (ms) => new Promise((next) => setTimeout(next, ms));

/** Asks until the head stands; its place. */
async function stands(status) {
  for (let tries = 0; tries < 400; tries += 1) {
    const now = await status();
    if (now.moveStatus.panTilt === 'IDLE' && now.moveStatus.zoom === 'IDLE') return now.position;
    await wait(25);
  }
  throw new Error('the head does not come to a stand');
}

// By version it gives tokens, or presets with theirs.
const tokenOf = (preset) => preset.$?.token ?? preset.token ?? preset;
const near = (value, wanted, what) => assert(Math.abs(Number(value) - wanted) < 1e-3, `${what}: ${value} in the place of ${wanted}`);

async function withOnvif() {
  const cam = await new Promise((done, failed) => {
    const made = new Cam({ hostname: '127.0.0.1', port, username: user, password, timeout: 10000 }, (problem) => (problem ? failed(problem) : done(made)));
  });
  const ask = (name, ...given) => promisify(cam[name].bind(cam))(...given);
  const status = () => ask('getStatus', {});
  const information = await ask('getDeviceInformation');
  assert.equal(information.manufacturer, 'camrig');
  const { uri } = await ask('getStreamUri', { protocol: 'RTSP' });
  assert.match(uri, /^rtsp:/);
  assert.match((await ask('getSnapshotUri', {})).uri, /^http:/);
  await ask('absoluteMove', { x: 0.1, y: 0.2, zoom: 0.25 });
  const there = await stands(status);
  near(there.x, 0.1, 'pan'); near(there.y, 0.2, 'tilt'); near(there.zoom, 0.25, 'zoom');
  await ask('setPreset', { presetName: 'node' });
  await ask('gotoHomePosition', {});
  near((await stands(status)).x, 0, 'home');
  const presets = await ask('getPresets', {});
  await ask('gotoPreset', { preset: tokenOf(presets.node) });
  near((await stands(status)).x, 0.1, 'the preset');
  await ask('relativeMove', { x: -0.05, y: 0, zoom: 0 });
  near((await stands(status)).x, 0.05, 'a step');
  await ask('continuousMove', { x: 0.2, y: 0, zoom: 0, timeout: 1000 });
  assert((await stands(status)).x > 0.06, 'a continuous move ends by its time-out');
  await ask('removePreset', { presetToken: tokenOf(presets.node) });
  await ask('gotoHomePosition', {});
  await stands(status);
  return { client: 'onvif', uri, presets: Object.keys(presets) };
}

async function withNodeOnvif() {
  const device = new OnvifDevice({ xaddr: `http://127.0.0.1:${port}/onvif/device_service`, user, pass: password });
  const information = await device.init();
  assert.equal(information.Manufacturer, 'camrig');
  const url = device.getUdpStreamUrl();
  assert.match(url, /^rtsp:/);
  const picture = await device.fetchSnapshot();
  assert.equal(picture.headers['content-type'], 'image/jpeg');
  assert(picture.body.length > 1000);
  const place = async () => {
    const token = device.getCurrentProfile().token;
    const answer = await device.services.ptz.getStatus({ ProfileToken: token });
    return Number(answer.data.GetStatusResponse.PTZStatus.Position.PanTilt.$.x);
  };
  const before = await place();
  await device.ptzMove({ speed: { x: 0.2, y: 0, z: 0 }, timeout: 30 });
  await wait(1000);
  await device.ptzStop();
  await wait(1500);
  const after = await place();
  assert(after > before + 0.01, 'it turned to the right');
  await wait(500);
  assert.equal(await place(), after, 'it stands after the stop');
  return { client: 'node-onvif', url, profiles: device.getProfileList().map((one) => one.token), picture: picture.body.length };
}

(async () => {
  for (const run of [withOnvif, withNodeOnvif]) console.log(JSON.stringify(await run()));
  process.exit(0); // their idle connections would hold it for seconds
})().catch((problem) => { console.error(problem); process.exit(1); });
