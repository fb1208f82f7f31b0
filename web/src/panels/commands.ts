// The list of all commands of the console. A module registers its commands once. The keyboard, the help and the palette read the
// same list, so they can never disagree.

export interface Command {
  /** Unique identifier such as `flight.pause`. */
  id: string;
  /** Heading in the help: "Flight", "Gains", "Charts", "Camera", "Page". */
  group: string;
  /** Description in the imperative: "pause or continue". */
  description: string;
  /** Chords as in `chord.ts`: "Space", "Ctrl+ArrowRight", "?", "M". Without a chord only the palette offers the command. */
  keys: string[];
  action(): void;
  /** Whether the command applies now. If it does not, its keys are free for another command or for the browser. */
  when?: () => boolean;
  /** Whether the command repeats while its key is held down. */
  repeats?: boolean;
  /** Whether the command also acts while the operator types a text or a number; for chords with Ctrl that no field uses. */
  whileTyping?: boolean;
  /** Whether the command makes sense only as a key; the help lists it, the palette does not. */
  keyOnly?: boolean;
}

export class Commands {
  private readonly all = new Map<string, Command>();

  /** Adds commands; a command with the same id is replaced. Returns a function that removes them again. */
  register(...commands: Command[]): () => void {
    commands.forEach((command) => this.all.set(command.id, command));
    return () => commands.forEach(({ id }) => this.all.delete(id));
  }

  list(): Command[] {
    return [...this.all.values()];
  }

  /** The command that `chord` starts now: of several commands that apply, the one that was registered last. */
  find(chord: string): Command | undefined {
    return this.list().findLast(({ keys, when }) => keys.includes(chord) && (when?.() ?? true));
  }

  /** Commands under their headings, headings in order of registration. */
  groups(): Map<string, Command[]> {
    const groups = new Map<string, Command[]>();
    for (const command of this.list()) groups.set(command.group, [...(groups.get(command.group) ?? []), command]);
    return groups;
  }
}

/** The console's own list: `commands.register({ id, group, description, keys, action, when })`. */
export const commands = new Commands();
