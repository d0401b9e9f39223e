from __future__ import annotations

from tests.pages.conftest import studied as studied
