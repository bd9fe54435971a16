// What the user is told: the rig's own words, until dismissed or for a while.

const shownMs = 12000;
const most = 4;
const list = document.getElementById('messages');

export function tell(text, kind = 'error') {
  for (const shown of list.children) if (shown.firstChild.textContent === text) shown.remove();
  const message = document.createElement('div');
  message.className = kind;
  const words = document.createElement('span');
  words.textContent = text;
  const close = document.createElement('button');
  close.type = 'button';
  close.textContent = '×';
  close.setAttribute('aria-label', 'Dismiss this message');
  close.addEventListener('click', () => message.remove());
  message.append(words, close);
  list.append(message);
  while (list.children.length > most) list.firstChild.remove();
  setTimeout(() => message.remove(), shownMs);
}

/** Runs what a control does; its failure is shown. Gives undefined then. */
export async function attempt(what) {
  try {
    return await what();
  } catch (problem) {
    if (problem.name !== 'AbortError') tell(problem.message);
    return undefined;
  }
}
