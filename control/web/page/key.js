// The key for commands (docs/web-page.md): it comes in the link that the rig printed, as #key=..., stays with this tab and
// leaves the address bar. Without it the page only looks.

const name = 'camrig-key';

function take() {
  const key = new URLSearchParams(location.hash.slice(1)).get('key');
  if (key === null) return;
  sessionStorage.setItem(name, key);
  history.replaceState(null, '', location.pathname + location.search);
}
take();
// The printed link opened in a tab that shows the page already.
window.addEventListener('hashchange', take);

/** Header fields of a command. */
export function authorization() {
  const key = sessionStorage.getItem(name);
  return key ? { Authorization: `Bearer ${key}` } : {};
}

/** A page with a token needs no key, and a rig may have been here before that had one. */
export function forgetKey() { sessionStorage.removeItem(name); }
