import { foundText, written, type Change, type Found } from "./steps";

interface Props {
  readonly numbers: readonly Found[];
  readonly writes: readonly Change[];
  readonly accepted: boolean;
}

/** What a step found, and what of it goes into the rig file. */
export function Findings({ numbers, writes, accepted }: Props) {
  return (
    <>
      {numbers.length === 0 ? null : (
        <table className="findings">
          <caption className="sr-only">What it found</caption>
          <tbody>
            {numbers.map((number) => (
              <tr key={number.name} data-grade={number.kept ? undefined : "bad"}>
                <th scope="row">{number.name}</th>
                <td className="number">{foundText(number)}</td>
                <td>
                  {number.bound}
                  {number.kept ? "" : " (not kept)"}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {writes.length === 0 ? null : (
        <div>
          <p className="note">{accepted ? "Written into the rig file" : "Accept writes into the rig file"}</p>
          <ul className="changes">
            {writes.map(({ field, before, after }) => (
              <li key={field}>
                <code>{field}</code>: {written(before)} → <b>{written(after)}</b>
              </li>
            ))}
          </ul>
        </div>
      )}
    </>
  );
}
