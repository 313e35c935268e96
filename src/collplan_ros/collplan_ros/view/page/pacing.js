// How often the picture is drawn: a browser that is slow at it leaves the time to the robot's own nodes.

const FAST = 30; // ms: a picture that takes no longer is drawn in every frame of the browser
const RAREST = 250; // ms between two pictures at most
const LEARNING = 0.2; // share of the newest picture in what one is taken to cost

/** Says in which frames of the browser to draw: where pictures are slow, at most half of the time. */
export class Pacing {
  constructor() {
    this.cost = 0; // ms
    this.begun = null; // moment of the picture whose cost is not known yet
    this.due = -Infinity;
  }

  /**
   * Whether to draw in the frame of a moment [ms, of requestAnimationFrame]. The browser calls for the next frame once it has
   * the last one on the screen: that a picture was drawn and the next frame was late tells what it cost.
   */
  draws(moment) {
    if (this.begun !== null) {
      this.cost += LEARNING * (Math.min(moment - this.begun, RAREST) - this.cost);
      this.due = this.cost > FAST ? this.begun + Math.min(2 * this.cost, RAREST) : -Infinity;
      this.begun = null;
    }
    if (moment < this.due) return false;
    this.begun = moment;
    return true;
  }
}
