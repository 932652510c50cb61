import { Component, type ReactNode } from "react";
import { Painters, RETRY_MS } from "./painters";
import { ServicesContext } from "./services";

interface Props {
  readonly name: string;
  /** Class of the place that it keeps while it fails. */
  readonly className?: string;
  readonly children: ReactNode;
}

interface State {
  readonly error: string | null;
}

/** A part of the page that may fail alone: the others stay, its place says so, and it is tried again. */
export class Part extends Component<Props, State> {
  static override contextType = ServicesContext;
  declare context: React.ContextType<typeof ServicesContext>;
  override state: State = { error: null };
  private readonly painter = { name: this.props.name };
  private timer: ReturnType<typeof setTimeout> | undefined;

  static getDerivedStateFromError(error: unknown): State {
    return { error: String(error) };
  }

  override componentDidCatch(error: unknown): void {
    this.context.get(Painters).threw(this.painter, performance.now(), error);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.setState({ error: null }), RETRY_MS);
  }

  override componentDidUpdate(_props: Props, before: State): void {
    if (before.error !== null && this.state.error === null)
      this.context.get(Painters).recovered(this.painter);
  }

  override componentWillUnmount(): void {
    clearTimeout(this.timer);
    this.context.get(Painters).recovered(this.painter);
  }

  override render(): ReactNode {
    const { name, className, children } = this.props;
    if (this.state.error === null) return children;
    return (
      <div className={`${className ?? ""} part-failed`} role="alert">
        {name}: {this.state.error}
      </div>
    );
  }
}
