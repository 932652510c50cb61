const plainFetch = fetch;
fetch = (request, options) =>
  new URL(request.url ?? request, location).origin === location.origin
    ? plainFetch(request, { ...options, credentials: "same-origin" })
    : plainFetch(request, options);
