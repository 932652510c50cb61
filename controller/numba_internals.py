"""What we use of numba that it does not promise to keep: every private name of it, and of llvmlite, stands here.

`pyproject.toml` bounds numba's version for their sake; a newer one is tried here first.
"""

from typing import Any

import llvmlite.ir
import numba
import numba.core.caching
import numba.core.cgutils
import numba.core.errors
import numba.core.imputils
import numba.core.types
import numba.core.typing.templates
import numba.extending
import numba.np.arrayobj

arrayobj: Any = numba.np.arrayobj
caching: Any = numba.core.caching
cgutils: Any = numba.core.cgutils
extending: Any = numba.extending
ir: Any = llvmlite.ir
lower_getattr_generic: Any = numba.core.imputils.lower_getattr_generic
templates: Any = numba.core.typing.templates
typeof: Any = numba.typeof
types: Any = numba.types
TypingError: type[Exception] = numba.core.errors.TypingError
unliteral: Any = numba.core.types.unliteral
