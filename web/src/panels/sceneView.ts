// The texts and controls over the 3-D view: the list of things to draw, the legend, the card of the chosen body, wind and push.
import type { Store } from "../data/store";
import { MOST_PUSH_N } from "../scene/push";
import type { World } from "../scene/world";
import { Beat } from "./beat";
import { BodyCard } from "./bodyCard";
import { commands } from "./commands";
import { byId, setText } from "./dom";
import { SceneKey } from "./sceneKey";
import { ARROW_KINDS, FRAME_KINDS, type KindInfo, MARK_KINDS } from "./viewKinds";
import { ViewPopover } from "./viewPopover";
import { WindBadge } from "./windBadge";

const GROUP = "3-D view";

export class SceneView {
  private readonly list: ViewPopover;
  private readonly key: SceneKey;
  private readonly card: BodyCard;
  private readonly wind: WindBadge;
  private readonly pushText = byId("push-text");
  private readonly texts = new Beat();

  constructor(
    private readonly world: World,
    store: Store,
  ) {
    this.list = new ViewPopover(world, () => this.settingsChanged());
    this.key = new SceneKey(world, () => store.channel("r_hat.x")?.unit ?? "N");
    this.card = new BodyCard(world, store);
    this.wind = new WindBadge(world);
    this.key.show();
    this.register();
  }

  /** Takes another flight. */
  rebuild(): void {
    this.list.rebuild();
    this.key.show();
    this.readings();
  }

  /** Takes note that another body was chosen, or none. */
  chosen(): void {
    this.list.show();
    this.card.readings();
  }

  /** Updates the texts; called once per frame. */
  frame(now: number): void {
    this.showPush();
    if (this.texts.due(now)) this.readings();
  }

  private readings(): void {
    this.key.readings();
    this.card.readings();
    this.wind.readings();
    this.list.readings();
  }

  private settingsChanged(): void {
    this.world.applySettings();
    this.list.show();
    this.key.show();
    this.wind.readings();
  }

  private showPush(): void {
    const { pointer, pushable } = this.world;
    this.pushText.hidden = !pointer.pushing;
    if (!pointer.pushing) return;
    const newtons = pointer.spring.force.length();
    const most = newtons >= MOST_PUSH_N - 0.01 ? " (most)" : "";
    setText(this.pushText, pushable ? `${newtons.toFixed(1)} N${most}` : "no push, because the flight is not running");
    const frame = this.pushText.parentElement?.getBoundingClientRect();
    this.pushText.style.transform = `translate(${pointer.cursor.x - (frame?.left ?? 0) + 16}px, ${pointer.cursor.y - (frame?.top ?? 0) - 12}px)`;
  }

  private register(): void {
    const { world } = this;
    const toggles = [...ARROW_KINDS, ...MARK_KINDS].map(({ kind, label, key }: KindInfo) => ({
      id: `view.${kind}`,
      group: GROUP,
      description: `show or hide: ${label}`,
      keys: key === undefined ? [] : [key],
      action: () => {
        world.settings.shown[kind] = !world.settings.shown[kind];
        this.settingsChanged();
      },
    }));
    commands.register(
      { id: "view.list", group: GROUP, description: "list the things to draw", keys: ["Shift+V"], action: () => this.list.toggle() },
      { id: "view.next", group: GROUP, description: "choose the next body", keys: ["N"], action: () => world.chooseNext(1) },
      { id: "view.previous", group: GROUP, description: "choose the previous body", keys: ["Shift+N"], action: () => world.chooseNext(-1) },
      { id: "view.none", group: GROUP, description: "stop the push, or choose no body", keys: ["Escape"], keyOnly: true, when: () => world.pointer.pushing || (world.chosenBody !== undefined && document.querySelector(":popover-open") === null), action: () => this.letGo() },
      { id: "view.axes", group: GROUP, description: "show or hide the axes of body, links, tool and payload", keys: ["Shift+X"], action: () => this.toggleAxes() },
      ...toggles,
    );
  }

  private letGo(): void {
    if (this.world.pointer.pushing) this.world.pointer.release();
    else this.world.choose(undefined);
  }

  private toggleAxes(): void {
    const { shown } = this.world.settings;
    const moving = FRAME_KINDS.map(({ kind }) => kind).filter((kind) => kind !== "world");
    const on = !moving.some((kind) => shown[kind]);
    moving.forEach((kind) => (shown[kind] = on));
    this.settingsChanged();
  }
}
