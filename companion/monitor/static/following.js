// The zoom of the map, which may keep the vehicle in its middle.

import { Zoom } from "./zoom.js";

const FOLLOWED = 3; // times as large as the whole map

export class FollowingZoom extends Zoom {
  constructor(box, whole, follow, changed) {
    super(box, whole, changed);
    this.follow = follow;
    this.isFollowing = false;
    follow.onclick = () => this.followOrNot();
  }

  show(view) {
    super.show(view);
    if (this.isWhole) this.touched();
  }

  followOrNot() {
    if (this.isFollowing) {
      this.touched();
      return;
    }
    this.isFollowing = true;
    this.follow.setAttribute("aria-pressed", "true");
    if (this.isWhole) this.zoom(FOLLOWED);
  }

  // Who moves the view follows nothing any more.
  touched() {
    this.isFollowing = false;
    this.follow.setAttribute("aria-pressed", "false");
  }
}
