import { Button, Paper, PasswordInput, Title } from "@mantine/core";
import { useState } from "react";
import { Connection } from "../live/connection";
import { textOf } from "../ui/format";
import { useService } from "../ui/services";

/** Asks for the access token that `tendril up` prints. */
export function Login() {
  const connection = useService(Connection);
  const [token, setToken] = useState("");
  const [problem, setProblem] = useState("");
  const [entering, setEntering] = useState(false);
  const enter = async () => {
    setEntering(true);
    try {
      await connection.login(token.trim());
    } catch (error) {
      setProblem(textOf(error));
    }
    setEntering(false);
  };
  return (
    <main className="login">
      <Paper withBorder p="xl" w={380} maw="100%">
        <form
          onSubmit={(event) => {
            event.preventDefault();
            void enter();
          }}
        >
          <Title order={1} size="h3" mb="md">
            Tendril
          </Title>
          <PasswordInput
            label="Access token"
            description="The operator's or the viewer's: `tendril token` prints them"
            data-testid="token"
            autoFocus
            value={token}
            error={problem || undefined}
            onChange={(event) => {
              setToken(event.currentTarget.value);
              setProblem("");
            }}
          />
          <Button
            type="submit"
            mt="md"
            fullWidth
            loading={entering}
            disabled={token.trim() === ""}
            data-testid="sign-in"
          >
            Sign in
          </Button>
        </form>
      </Paper>
    </main>
  );
}
