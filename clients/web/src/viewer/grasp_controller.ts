// The grasps opened by the user: the drawn ones, the chosen one, and their validity as the world
// changes.
import type { Picture } from "./draw/picture";
import { FileOpener } from "./file_opener";
import { checkSize, GraspFileError, parseGrasps, planWarning, staleness, type Grasp, type GraspPlan } from "./grasps";
import { GraspPanel } from "./panels/grasp_panel";
import { emptyWorld, type WorldState } from "./world_model";

export class GraspController {
  readonly panel: GraspPanel;
  readonly opener = new FileOpener((file) => void this.open(file));
  private plan: GraspPlan | undefined;
  private chosen: Grasp | undefined;
  private isAll = false;
  private isOn = true;
  private state: WorldState = emptyWorld;
  private stale = new Map<string, string>();  // the reason, by object

  // `chose` is called with the object of the chosen grasp.
  constructor(private readonly picture: Picture, private readonly chose: (object: string) => void) {
    this.panel = new GraspPanel({
      choose: (grasp) => this.choose(grasp), close: () => this.close(),
      showAll: (isAll) => {
        this.isAll = isAll;
        this.draw();
      } });
  }

  follow(state: WorldState): void {
    this.state = state;
    if (!this.plan) return;
    const before = JSON.stringify([...this.stale]);
    this.judge(this.plan);
    if (JSON.stringify([...this.stale]) !== before) this.draw();
  }

  turn(isOn: boolean): void {
    this.isOn = isOn;
    this.draw();
  }

  choose(grasp: Grasp): void {
    this.chosen = grasp;
    this.panel.choose(grasp);
    this.draw();
    this.chose(grasp.object);
  }

  // Called if another object was selected, or none.
  selected(object: string | undefined): void {
    if (!this.chosen || this.chosen.object === object || !this.state.objects.has(this.chosen.object)) return;
    this.chosen = undefined;
    this.panel.choose(undefined);
    this.draw();
  }

  facts(): Record<string, unknown> {
    return { grasps: this.plan?.grasps.length ?? 0, grippers: this.picture.grasps.count, chosen_grasp: this.chosen?.rank ?? 0 };
  }

  private async open(file: File): Promise<void> {
    try {
      checkSize(file.size);
      this.plan = parseGrasps(await file.text());
    } catch (error) {
      const isGone = error instanceof DOMException;  // a folder, or a file that was removed meanwhile
      if (!(error instanceof GraspFileError || isGone)) throw error;
      this.panel.showError(file.name, isGone ? `it cannot be read: ${error.message}` : error.message);
      return;
    }
    this.chosen = undefined;
    this.panel.show(file.name, this.plan, this.isAll);
    this.judge(this.plan);
    this.draw();
  }

  private close(): void {
    this.plan = undefined;
    this.chosen = undefined;
    this.panel.clear();
    this.draw();
  }

  private why({ object }: Grasp): string { return this.stale.get(object) ?? ""; }

  private judge(plan: GraspPlan): void {
    this.stale = new Map(plan.grasps.filter(({ isBest }) => isBest)
      .map(({ object }) => [object, staleness(plan, object, this.state)]));
    this.panel.showStaleness(planWarning(plan, this.state), (grasp) => this.why(grasp));
  }

  private draw(): void {
    const { plan, chosen } = this;
    if (!plan) {
      this.picture.setGrasps(undefined);
      return;
    }
    const seen = plan.grasps.filter((grasp) => this.isOn && (this.isAll || grasp.isBest || grasp === chosen));
    this.picture.setGrasps({
      boxes: plan.boxes, chosen, shown: seen.map((grasp) => ({ grasp, isStale: this.why(grasp) !== "" })) });
  }
}
