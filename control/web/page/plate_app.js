// Puts the page of photos together (docs/web-page.md).
import './key.js';
import './plate_photo.js';
import './plate_picture.js';
import './plate_drawing.js';
import './plate_clicks.js';
import './plate_light.js';
import './plate_view.js';
import './plate_measure.js';
import './plate_scene.js';
import { change } from './plate_state.js';

change({});
