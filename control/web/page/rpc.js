// Calls of the control protocol (docs/control-protocol.md) by POST /rpc.
import { authorization } from './key.js';

export class RpcError extends Error {
  constructor({ message, data }) {
    super(message);
    this.kind = data?.kind ?? 'internal';
  }
}

async function post(body, signal) {
  let reply;
  try {
    const headers = { 'Content-Type': 'application/json', ...authorization() };
    reply = await fetch('rpc', { method: 'POST', headers, body: JSON.stringify(body), signal });
  } catch (problem) {
    if (problem.name === 'AbortError') throw problem;
    throw new RpcError({ message: 'no answer from the rig: ' + problem.message, data: { kind: 'unavailable' } });
  }
  const answer = await reply.json();
  if (!reply.ok) throw new RpcError({ message: answer.error.message, data: answer.error });
  return answer;
}

/** The result of one call; an RpcError carries the rig's own message. */
export async function call(method, params = {}, signal = undefined) {
  const answer = await post({ jsonrpc: '2.0', id: 1, method, params }, signal);
  if (answer.error) throw new RpcError(answer.error);
  return answer.result;
}

/** The results of several calls without parameters, by name, in one request. */
export async function callAll(methods, signal) {
  const answers = await post(methods.map((method, id) => ({ jsonrpc: '2.0', id, method })), signal);
  const results = {};
  for (const answer of answers) {
    if (answer.error) throw new RpcError(answer.error);
    results[methods[answer.id]] = answer.result;
  }
  return results;
}
