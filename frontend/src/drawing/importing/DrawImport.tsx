import { FileButton, Modal } from "@mantine/core";
import { useWindowEvent } from "@mantine/hooks";
import { IconFileImport } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import { ToolButton } from "../../ui/buttons/ToolButton";
import { textOf } from "../../ui/format";
import { ImportFrame } from "./ImportFrame";
import { parseSvg, type SvgPath } from "./svg";
import { ImportError } from "./svgCopy";
import { SvgImport } from "./SvgImport";
import { TableImport } from "./TableImport";

/** A CSV or SVG file becomes a drawing: chosen by this button, or dropped on the page; a dialog shows it first. */
export function DrawImport() {
  const [chosen, setChosen] = useState<{ readonly file: File; readonly count: number } | null>(null);
  const again = useRef<() => void>(null);
  const choose = (file: File | null) => {
    again.current?.(); // the same file may be chosen once more, mended
    if (file) setChosen((before) => ({ file, count: (before?.count ?? 0) + 1 }));
  };
  useWindowEvent("dragover", (event) => {
    event.preventDefault();
  });
  useWindowEvent("drop", (event) => {
    event.preventDefault();
    choose(event.dataTransfer?.files.item(0) ?? null);
  });
  const label = "Import a table (CSV: x, y or t, x, y) or an SVG drawing; or drop the file here";
  return (
    <>
      <FileButton
        accept=".csv,.txt,.tsv,.dat,.svg,text/csv,text/plain,image/svg+xml"
        resetRef={again}
        inputProps={{ "aria-label": "File to import" }}
        onChange={choose}
      >
        {(button) => (
          <ToolButton {...button} label={label} testId="tool-import">
            <IconFileImport size={18} />
          </ToolButton>
        )}
      </FileButton>
      {chosen ? <ImportDialog key={chosen.count} file={chosen.file} onClose={() => setChosen(null)} /> : null}
    </>
  );
}

interface Props {
  readonly file: File;
  readonly onClose: () => void;
}

/** Largest files that are read: the page would stand still over a larger drawing, the server takes no larger table. */
const SVG_MAX = 2_000_000;
const TABLE_MAX = 1_048_576;
/** Characters at the beginning that tell the one from the other. */
const BEGINNING = 4096;

type Read = { readonly svg: SvgPath } | { readonly problem: string } | "table";

/** What is understood of a file that was chosen, before it becomes a drawing. */
function ImportDialog({ file, onClose }: Props) {
  const [read, setRead] = useState<Read | null>(null);
  useEffect(() => {
    let current = true;
    void readIn(file)
      .catch((error: unknown): Read => ({ problem: textOf(error) }))
      .then((what) => {
        if (current) setRead(what);
      });
    return () => {
      current = false;
    };
  }, [file]);
  return (
    <Modal
      opened
      onClose={onClose}
      title={`Import ${file.name}`}
      size="lg"
      closeButtonProps={{ "aria-label": "Close" }}
    >
      <p className="note">{file.size} bytes; nothing is drawn before you press Import.</p>
      {read === null ? null : read === "table" ? (
        <TableImport file={file} onClose={onClose} />
      ) : "svg" in read ? (
        <SvgImport file={file} path={read.svg} onClose={onClose} />
      ) : (
        <ImportFrame file={file} found={null} question="" problem={read.problem} onClose={onClose} />
      )}
    </Modal>
  );
}

/** Tells an SVG file, which is read here, from a table, which the server reads. */
async function readIn(file: File): Promise<Read> {
  const beginning = await file.slice(0, BEGINNING).text();
  const isSvg = /\.svg$/i.test(file.name) || /<svg[\s>]/.test(beginning);
  const most = isSvg ? SVG_MAX : TABLE_MAX;
  if (file.size === 0) throw new ImportError("The file is empty");
  if (file.size > most)
    throw new ImportError(
      `The file has ${file.size} bytes, more than ${most}: take fewer points or a part of it`,
    );
  return isSvg ? { svg: parseSvg(await file.text()) } : "table";
}
