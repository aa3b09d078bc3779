"""Who may ask the server what: this machine's browser with the token of this book, and no page of elsewhere.

The token of the address that `labbook web` prints becomes a cookie. `Host` is checked against DNS rebinding, `Origin`
against forms of other pages; the content security policy lets nothing run that does not come from here.
"""

from __future__ import annotations

import secrets
from collections.abc import Collection
from dataclasses import dataclass

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


@dataclass(frozen=True, slots=True)
class Guard:
    """An application behind the checks; `hosts` are the names and ports under which it may be asked.

    `cookie` names the cookie: browsers keep those of all ports together, and another book has another. `once` are
    tokens that open the page one time: that of a command line, which every user of the machine may list.
    """

    app: ASGIApp
    token: str
    once: set[str]
    cookie: str
    hosts: Collection[str]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what may be asked, and refuse the rest in a sentence."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        refusal = self._refusal(Request(scope))
        await (self.app if refusal is None else refusal)(scope, receive, send_guarded)

    def _refusal(self, request: Request) -> Response | None:
        """Return the answer to what may not be asked, or to the token in an address; None where all is well."""
        host, origin = request.headers.get("host", ""), request.headers.get("origin")
        if host not in self.hosts:
            return PlainTextResponse(
                f"{host!r} is not an address of this page: use the one that labbook printed.\n", 400
            )
        if origin not in (None, f"http://{host}") or (request.method != "GET" and origin is None):
            return PlainTextResponse("This was asked by another page, and is refused.\n", 403)
        given = request.query_params.get("token")
        if given is not None and request.method == "GET" and self._opens(given):
            url = request.url.remove_query_params("token")
            response = RedirectResponse(f"{url.path}?{url.query}" if url.query else url.path, 303)
            response.set_cookie(self.cookie, self.token, httponly=True, samesite="strict")
            return response
        if not _same(request.cookies.get(self.cookie, ""), self.token):
            return PlainTextResponse("Open the page by the address that labbook printed, with its token.\n", 403)
        return None

    def _opens(self, given: str) -> bool:
        used = {token for token in self.once if _same(given, token)}
        self.once.difference_update(used)
        return bool(used) or _same(given, self.token)


def _same(given: str, token: str) -> bool:
    return secrets.compare_digest(given.encode(), token.encode())
