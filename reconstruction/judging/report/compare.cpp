// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/compare.h"

namespace dpl {

const char* const kCompareStyle = R"(
.compare{margin:1rem 0}.layers{position:relative;display:grid;width:fit-content;max-width:100%;margin:0 auto;touch-action:pan-y;cursor:ew-resize}
.layers img{grid-area:1/1;height:min(75vh,120vw);max-width:100%;object-fit:contain;background:#fff}
.layers .over{clip-path:inset(0 0 0 var(--at))}.layers .line{position:absolute;top:0;bottom:0;left:var(--at);width:2px;background:var(--accent)}
.compare [hidden]{display:none}.compare input{display:block;width:min(100%,30rem);margin:.6rem auto}
.compare p{display:flex;flex-wrap:wrap;gap:.4rem;justify-content:center;align-items:center;margin:.3rem 0}
.compare button{font:inherit;padding:.2rem .8rem;border:1px solid var(--line);border-radius:1rem;background:none;color:inherit;cursor:pointer}
.compare button[aria-pressed=true]{background:var(--accent);color:#fff}
)";

const char* const kCompareScript = R"js((() => {
  const pairs = [...document.querySelectorAll('.pairs figure')].map(figure => [...figure.querySelectorAll('img')]);
  const differences = document.querySelectorAll('.differences img');
  if (!pairs.length) return;
  const make = (tag, into, set = {}) => into.appendChild(Object.assign(document.createElement(tag), set));
  const box = Object.assign(document.createElement('div'), { className: 'compare' });
  document.querySelector('.pairs').before(box);
  const layers = make('div', box, { className: 'layers' });
  const [truth, avatar, difference] = ['under', 'over', 'difference'].map(className => make('img', layers, { className, draggable: false }));
  const line = make('div', layers, { className: 'line' });
  const slider = make('input', box, { type: 'range', min: 0, max: 100, value: 50, ariaLabel: 'Left of it the picture, right of it the avatar' });
  const row = make('p', box);
  let current = 0, differs = false;
  const button = (textContent, onclick) => make('button', row, { type: 'button', textContent, onclick });
  const step = by => () => {
    current = (current + by + pairs.length) % pairs.length;
    show();
  };
  const choose = now => () => {
    differs = now;
    show();
  };
  button('‹', step(-1)).ariaLabel = 'The picture before';
  const compare = button('Picture | avatar', choose(false)), differ = button('Difference', choose(true));
  button('›', step(1)).ariaLabel = 'The next picture';
  const count = make('span', row, { className: 'soft' });
  function show() {
    const images = [pairs[current][0], pairs[current][1], differences[current]];
    [truth, avatar, difference].forEach((image, i) => {
      image.src = images[i]?.src ?? '';
      image.alt = images[i]?.alt ?? '';
    });
    differ.hidden = !images[2];
    difference.hidden = !differs || !images[2];
    truth.hidden = avatar.hidden = slider.hidden = line.hidden = !difference.hidden;
    compare.setAttribute('aria-pressed', difference.hidden);
    differ.setAttribute('aria-pressed', !difference.hidden);
    count.textContent = `${current + 1} of ${pairs.length}`;
  }
  const place = () => layers.style.setProperty('--at', `${slider.value}%`);
  slider.oninput = place;
  layers.onpointerdown = layers.onpointermove = event => {
    if (event.type === 'pointermove' && !event.buttons) return;
    const { left, width } = layers.getBoundingClientRect();
    slider.value = 100 * (event.clientX - left) / width;
    place();
  };
  place();
  show();
})();)js";

}  // namespace dpl
