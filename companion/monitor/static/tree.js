// The behaviour tree: an indented list. What runs is open; what is done or has not begun is closed,
// unless somebody has opened it.

import { byId, html, setStatus, statusShape } from "./dom.js";
import { meaningOf } from "./explained.js";

const SIGNS = {
  sequence: "→", reactive_sequence: "→", selector: "?", parallel: "⇉", subtree: "→", action: "?",
  repeat: "↻", retry: "◇", inverter: "◇", timeout: "◇", leaf: "",
};

export class TreeView {
  show(state) {
    if (this.drawn !== state.touched.tree) this.draw(state);
    if (this.told !== state.touched.status || this.drawn !== state.touched.tree) this.update(state);
    this.drawn = state.touched.tree;
    this.told = state.touched.status;
  }

  draw(state) {
    const root = html("div", { class: "node" });
    const parents = [root];
    this.rows = state.nodes.map((node, i) => {
      const isInner = (state.nodes[i + 1]?.depth ?? -1) > node.depth;
      const shape = statusShape("INVALID");
      const said = html("span", { class: "said" });
      const label = [
        shape, html("span", { class: "sign", "aria-hidden": "true" }, SIGNS[node.type]),
        html("span", { class: "label" }, node.name), said,
      ];
      const explained = { "data-explain": meaningOf(node), "aria-describedby": isInner && "tip" };
      const element = isInner
        ? html("details", { class: node.type }, html("summary", explained, ...label))
        : html("div", { class: "leaf", ...explained }, ...label);
      parents.length = node.depth + 1;
      parents[node.depth].append(element);
      parents.push(element);
      const row = { element, shape, said, isInner, isAction: node.type === "action", isChosen: false };
      element.firstChild.addEventListener("click", () => { row.isChosen = true; });
      return row;
    });
    byId("tree").replaceChildren(root);
  }

  update(state) {
    let below = -1; // depth of the action that the present node belongs to
    this.rows.forEach((row, i) => {
      const status = state.statuses[i];
      setStatus(row.shape, status);
      row.element.dataset.status = status;
      row.said.textContent = state.said[i];
      const { depth } = state.nodes[i];
      if (depth <= below) below = -1;
      if (row.isAction) below = depth;
      if (row.isInner && !row.isChosen) row.element.open = below < 0 || isOnTheWay(status);
    });
  }
}

const isOnTheWay = (status) => status === "RUNNING" || status === "FAILURE";

// The actions of the tree in the order of the plan, those of the loop marked, with their statuses.
export function actionsOf(state) {
  let loop = Infinity; // depth of the repeat that the present node belongs to
  return state.nodes.flatMap((node, i) => {
    if (node.depth <= loop) loop = Infinity;
    if (node.type === "repeat") loop = node.depth;
    return node.type === "action"
      ? [{ ...node, status: state.statuses[i], isInLoop: loop < node.depth }]
      : [];
  });
}
