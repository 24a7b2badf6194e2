/** The connection to the program; reconnects automatically. */
import type { Command, State } from './protocol';

type Message = State | { type: 'error'; text: string };
type Outgoing = ({ type: 'command' } & Command) | { type: 'drive' } | { type: 'release' } | { type: 'damp' };

const firstPause = 300; // pause before reconnecting [ms]
const longestPause = 3000;

export class Link {
  onState: (state: State) => void = () => {};
  onError: (text: string) => void = () => {};
  onOpen: () => void = () => {};
  onClose: () => void = () => {};
  private socket: WebSocket | null = null;
  private pause = firstPause;

  constructor(private readonly url: string) {}

  open(): void {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    socket.onopen = () => {
      this.pause = firstPause;
      this.onOpen();
    };
    socket.onmessage = (event: MessageEvent<string>) => {
      const message = JSON.parse(event.data) as Message;
      if (message.type === 'state') this.onState(message);
      else if (message.type === 'error') this.onError(message.text);
    };
    socket.onclose = () => {
      this.onClose();
      setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(2 * this.pause, longestPause);
    };
  }

  send(message: Outgoing): void {
    // Drop what cannot be sent now: it would be outdated later.
    if (this.socket?.readyState !== WebSocket.OPEN || this.socket.bufferedAmount > 10_000) return;
    this.socket.send(JSON.stringify(message));
  }
}
