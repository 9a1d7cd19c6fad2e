// The controls of a capture's keys, made of what the server says of them.

const element = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};

/** A number as people read it. */
export function readable(value, digits = 4) {
  if (typeof value !== "number") return String(value ?? "");
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(2) : String(+value.toPrecision(digits));
}

/** Where sliders stand whose key is not set. */
const UNSET = { "develop.temperature_k": 5500, "develop.tint": 0, "develop.sharpening_radius_px": 1 };

/** An exposure time as cameras show it. */
const time = s => s < 0.25 ? `1/${readable(1 / s, 3)} s` : `${readable(s)} s`;

export class Controls {
  /** `changed(key, value)` hears of a change, with `undefined` where a control is reset. */
  constructor(root, controls, changed) {
    this.controls = new Map();
    this.groups = new Map();
    for (const control of controls) {
      if (!this.groups.has(control.group)) {
        const group = element("details", { open: true }, element("summary", { textContent: control.group }));
        this.groups.set(control.group, group);
        root.append(group);
      }
      const made = this.make(control, value => changed(control.key, value));
      this.groups.get(control.group).append(made.root);
      this.controls.set(control.key, made);
    }
  }

  make(control, changed) {
    const { key, label, kind, unit, about } = control;
    const id = "control-" + key.replace(/\W/g, "-");
    const root = element("div", { className: "control", title: about });
    const output = element("output", { htmlFor: id });
    const undo = element("button", { className: "undo", type: "button", textContent: "↺", title: `Reset ${label}`, ariaLabel: `Reset ${label}`, hidden: true });
    undo.onclick = () => changed(undefined);
    const name = element("label", { className: "name", htmlFor: id, textContent: label });
    const anew = element("small", { className: "anew", textContent: "traces again", hidden: true });
    const head = element("div", { className: "head" }, name, anew, output, undo);
    let show;
    if (kind === "linear" || kind === "logarithmic") {
      const [min, max] = kind === "linear" ? [control.min, control.max] : [Math.log2(control.min), Math.log2(control.max)];
      const input = element("input", { id, type: "range", min, max, step: kind === "linear" ? control.step : 1 / 12, ariaLabel: label });
      const value = () => kind === "linear" ? +input.value : 2 ** +input.value;
      const inWords = v => key.endsWith("time_s") ? time(v) : key === "lens.f_number" ? `f/${readable(v, 3)}` : `${readable(v)} ${unit}`;
      const text = v => v === null || v === undefined ? "" : inWords(v);
      input.oninput = () => { output.value = text(value()); input.ariaValueText = output.value; changed(+value().toPrecision(6)); };
      show = v => {
        const isUnset = v === null || v === undefined;
        output.value = isUnset ? "not set" : text(v);
        input.ariaValueText = output.value;
        const at = isUnset ? UNSET[key] ?? 0 : v;
        if (document.activeElement !== input || undo.hidden) input.value = kind === "linear" ? at : Math.log2(at);
      };
      root.append(head, input);
    } else if (kind === "whole") {
      const input = element("input", { id, type: "number", min: control.min, max: control.max, step: 1, ariaLabel: label });
      input.oninput = () => { if (input.checkValidity() && input.value !== "") changed(+input.value); };
      show = v => { if (document.activeElement !== input) input.value = v; };
      head.append(input);
      root.append(head);
    } else if (kind === "flag") {
      const input = element("input", { id, type: "checkbox", ariaLabel: label });
      input.onchange = () => changed(input.checked);
      show = v => { input.checked = v; };
      head.append(input);
      root.append(head);
    } else if (kind === "choice") {
      const select = element("select", { id, ariaLabel: label }, ...control.options.map(({ name, about }) => element("option", { value: name, textContent: name, title: about })));
      select.onchange = () => changed(select.value);
      show = v => {
        // A sensor of a file of its own has another name.
        if (v && ![...select.options].some(option => option.value === v)) select.prepend(element("option", { value: v, textContent: v, disabled: true }));
        select.value = select.title = v;
      };
      head.append(select);
      root.append(head);
    } else {
      // What takes part is ticked; the key lists what is left out.
      const boxes = control.options.map(({ name, about }) => {
        const box = element("input", { type: "checkbox", value: name, checked: true, ariaLabel: name });
        box.onchange = () => changed(boxes.filter(one => !one.checked).map(one => one.value));
        return box;
      });
      const all = on => element("button", { type: "button", textContent: on ? "All" : "None", ariaLabel: `${label}: ${on ? "all" : "none"}`, onclick: () => changed(on ? [] : boxes.map(box => box.value)) });
      const list = element("fieldset", {}, element("legend", { textContent: label }), element("div", { className: "row" }, all(true), all(false)),
        ...boxes.map((box, i) => element("label", { className: "check", title: control.options[i].about }, box, control.options[i].name.replaceAll("-", " "))));
      // Those that the sensor does not have keep their ticks, for a sensor that has them.
      show = (off, offered) => boxes.forEach(box => {
        box.checked = !(off ?? []).includes(box.value);
        box.parentElement.hidden = !(offered ?? [box.value]).includes(box.value);
      });
      head.replaceChildren(undo);
      root.append(element("details", {}, element("summary", { textContent: label }), list, head));
    }
    return { root, show, undo, anew };
  }

  /** Shows values as they are and which of them are changed; hides what has no value, groups of nothing else, and stages that are
   * not among those of the sensor. */
  show(settings, changed, stages) {
    for (const [key, made] of this.controls) {
      const is = Object.hasOwn(changed, key);
      made.undo.hidden = !is;
      made.root.classList.toggle("changed", is);
      made.root.hidden = !Object.hasOwn(settings, key);
      if (!made.root.hidden) made.show(is ? changed[key] : settings[key], stages);
    }
    for (const group of this.groups.values()) {
      group.hidden = ![...group.querySelectorAll(".control")].some(control => !control.hidden);
    }
  }

  /** The keys of all controls. */
  keys() {
    return this.controls.keys();
  }

  /** Marks a control whose value needs light to be traced anew. */
  mark(key, isAnew) {
    const made = this.controls.get(key);
    if (made) made.anew.hidden = !isAnew;
  }
}

/** A value as a query has it. */
export const inQuery = value => Array.isArray(value) ? value.join(",") : String(value);
