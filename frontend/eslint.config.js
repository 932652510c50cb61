import reactHooks from "eslint-plugin-react-hooks";
import { defineConfig, globalIgnores } from "eslint/config";
import tseslint from "typescript-eslint";
import rooms from "./rooms.js";

export default defineConfig(
  globalIgnores(["node_modules", "public", "scripts", "eslint.config.js", "rooms.js", "src/api/schema.d.ts"]),
  tseslint.configs.strictTypeChecked,
  reactHooks.configs.flat.recommended,
  { languageOptions: { parserOptions: { projectService: true } } },
  {
    rules: {
      "@typescript-eslint/switch-exhaustiveness-check": "error",
      // A handler of one call is one line: onClick={() => close()} says no less than with braces.
      "@typescript-eslint/no-confusing-void-expression": ["error", { ignoreArrowShorthand: true }],
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true }],
      "max-lines": ["error", 400],
    },
  },
  rooms,
);
