interface Props {
  readonly facts: readonly (readonly [string, string])[];
  readonly testId: string;
}

/** Names with their values. */
export function Facts({ facts, testId }: Props) {
  return (
    <dl className="facts" data-testid={testId}>
      {facts.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd className="number">{value}</dd>
        </div>
      ))}
    </dl>
  );
}
