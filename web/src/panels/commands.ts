// The list of everything the console can be told to do. A module registers its commands once; the keyboard, the help
// and the palette read them from here and so can never disagree.

export interface Command {
  /** Unique, `flight.pause`. */
  id: string;
  /** Heading in the help: "Flight", "Gains", "Charts", "Camera", "Page". */
  group: string;
  /** What it does, in the imperative: "pause or continue". */
  description: string;
  /** Chords as in `chord.ts`: "Space", "Ctrl+ArrowRight", "?", "M". None: only the palette offers it. */
  keys: string[];
  action(): void;
  /** Applies now; a key whose command does not apply is free for another command, or for the browser. */
  when?: () => boolean;
  /** Acts again and again while the key is held. */
  repeats?: boolean;
  /** Acts while a text or number is being typed as well; for chords with Ctrl that no field knows. */
  whileTyping?: boolean;
  /** Listed in the help, not in the palette: makes sense only as a key. */
  keyOnly?: boolean;
}

export class Commands {
  private readonly all = new Map<string, Command>();

  /** Adds commands; one of the same id is replaced. Gives back what takes them away again. */
  register(...commands: Command[]): () => void {
    commands.forEach((command) => this.all.set(command.id, command));
    return () => commands.forEach(({ id }) => this.all.delete(id));
  }

  list(): Command[] {
    return [...this.all.values()];
  }

  /** The command `chord` stands for now: of several that apply, the one registered last. */
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
