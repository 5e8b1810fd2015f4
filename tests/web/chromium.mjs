// SPDX-License-Identifier: Apache-2.0
// Headless Chromium by its debugging pipe, without a library: opens pages from disk and runs expressions in them.
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { removeProfile } from './profile.mjs';

const LIMIT_MS = 600000;

/** Starts the browser. work: a folder for its profile. */
export async function startChromium(program, work) {
  const profile = fs.mkdtempSync(path.join(work, 'profile-'));
  const process_ = spawn(program, ['--headless=new', '--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking',
    '--remote-debugging-pipe', `--user-data-dir=${profile}`, 'about:blank'], { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
  const waiting = new Map(), listeners = new Set();
  let number = 0, rest = '';
  process_.stdio[4].setEncoding('utf8').on('data', text => {
    const messages = (rest + text).split('\0');
    rest = messages.pop();
    for (const message of messages.map(m => JSON.parse(m))) {
      if (message.id) {
        const { done, fail } = waiting.get(message.id);
        waiting.delete(message.id);
        if (message.error) fail(new Error(message.error.message));
        else done(message.result);
      } else {
        for (const listener of listeners) listener(message);
      }
    }
  });
  const ended = new Promise(done => process_.on('exit', done));
  ended.then(code => { for (const { fail } of waiting.values()) fail(new Error(`the browser ended with ${code}`)); });
  const send = (method, params = {}, sessionId = undefined) => new Promise((done, fail) => {
    waiting.set(++number, { done, fail });
    process_.stdio[3].write(JSON.stringify({ id: number, method, params, sessionId }) + '\0');
  });

  /** A page of its own: {requests, errors, eval, until, screenshot, close}. width, height: CSS pixels; scripts: false turns them off. */
  async function open(url, { width = 1280, height = 800, scripts = true } = {}) {
    const { browserContextId } = await send('Target.createBrowserContext');
    const { targetId } = await send('Target.createTarget', { url: 'about:blank', browserContextId });
    const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
    const page = { requests: [], errors: [] };
    const listen = message => {
      if (message.sessionId !== sessionId) return;
      if (message.method === 'Network.requestWillBeSent') page.requests.push(message.params.request.url.slice(0, 100));
      if (message.method === 'Runtime.exceptionThrown') page.errors.push(JSON.stringify(message.params.exceptionDetails).slice(0, 400));
    };
    listeners.add(listen);
    const call = (method, params) => send(method, params, sessionId);
    await Promise.all([call('Page.enable'), call('Network.enable'), call('Runtime.enable')]);
    await call('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: width < 600 });
    await call('Emulation.setScriptExecutionDisabled', { value: !scripts });
    const loaded = new Promise(done => {
      const once = message => {
        if (message.sessionId === sessionId && message.method === 'Page.loadEventFired') listeners.delete(once), done();
      };
      listeners.add(once);
    });
    await call('Page.navigate', { url });
    await loaded;
    return Object.assign(page, {
      async eval(expression) {
        const { result, exceptionDetails } = await call('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
        if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
        return result.value;
      },
      /** Waits until the expression is true. */
      async until(expression) {
        for (const end = Date.now() + LIMIT_MS; !await this.eval(expression);) {
          if (Date.now() > end) throw new Error(`never: ${expression}; ${page.errors.join('\n')}`);
          await new Promise(next => setTimeout(next, 50));
        }
      },
      /** A PNG of what is on the screen. */
      async screenshot(file) {
        const { data } = await call('Page.captureScreenshot', { format: 'png' });
        fs.writeFileSync(file, Buffer.from(data, 'base64'));
      },
      async close() {
        listeners.delete(listen);
        await send('Target.disposeBrowserContext', { browserContextId });
      },
    });
  }

  return {
    open,
    async close() {
      await send('Browser.close').catch(() => {});
      await ended;
      await removeProfile(profile);
    },
  };
}
