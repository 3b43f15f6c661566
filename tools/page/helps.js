// What a word means, beside it: on hovering and on keyboard focus. A screen reader reads the same text by aria-describedby.
export function startHelps() {
  const tip = Object.assign(document.createElement("div"), { className: "help-tip", hidden: true });
  tip.setAttribute("aria-hidden", "true");
  document.body.append(tip);
  const show = (event) => {
    const word = event.target.closest?.("[aria-describedby^='help-']");
    const text = word && document.getElementById(word.getAttribute("aria-describedby"))?.textContent;
    tip.hidden = !text;
    if (!text) return;
    tip.textContent = text;
    const { left, bottom, top } = word.getBoundingClientRect();
    tip.style.left = `${Math.max(4, Math.min(left, innerWidth - tip.offsetWidth - 4))}px`;
    tip.style.top = `${bottom + tip.offsetHeight + 8 < innerHeight ? bottom + 4 : top - tip.offsetHeight - 4}px`;
  };
  const hide = () => { tip.hidden = true; };
  for (const event of ["mouseover", "focusin"]) document.addEventListener(event, show);
  for (const event of ["focusout", "scroll", "beforeprint"]) addEventListener(event, hide);
  document.addEventListener("keydown", (event) => event.key === "Escape" && hide());
}
