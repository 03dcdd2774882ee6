# The explorer as a container that needs nothing but a temporary folder:
#
#   docker run --read-only --tmpfs /tmp --cap-drop ALL --security-opt no-new-privileges -p 127.0.0.1:5006:5006 \
#       -e VIBROSCOPE_ORIGINS=localhost:5006 vibroscope
#
# VIBROSCOPE_ORIGINS names the host in the browser's address bar. No RUN --mount: builders other than BuildKit must
# manage too. `make image` builds and runs it without any container engine.

# as of 2026-10-15, supported until 2027-10-31 (tools/images.py says when it ages)
ARG BASE=python:3.11.17-slim-trixie@sha256:45037981b62b34b44602584fccbc4d884d5f7dc92c7ee86bb38a698a79fe1e51

FROM ${BASE} AS build
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1
WORKDIR /opt/vibroscope

# The linker's tools do not stay in the image, and a pinned version would vanish from the mirrors with the next one.
# hadolint ignore=DL3008
RUN apt-get update --quiet \
 && apt-get install --quiet --yes --no-install-recommends binutils \
 && rm -rf /var/lib/apt/lists/*

COPY requirements/image.txt requirements/
RUN python3 -m venv .venv \
 && .venv/bin/python -m pip install --no-compile --require-hashes --only-binary :all: -r requirements/image.txt

COPY . .
RUN .venv/bin/python -m pip install --no-deps --no-build-isolation --editable . \
 && .venv/bin/python -m pip uninstall --yes --quiet setuptools pip \
 && tools/trim-image .venv

# Bytecode is left of what these runs import, which is what the server imports, at its start and for its first picture.
ENV VIBROSCOPE_CACHE_DIR=/opt/vibroscope/cache
RUN tools/container-entry .venv/bin/vibroscope warm \
 && NUMBA_CPU_NAME=generic tools/container-entry .venv/bin/vibroscope warm \
 && .venv/bin/python -c "import vibroscope.app.server.server" \
 && .venv/bin/python -c "from matplotlib.backends import backend_agg, backend_pdf, backend_svg" \
 && .venv/bin/python -m compileall -q app assets engine


# The documentation, with its figures, and a wheel beside it, which /docs/wheel/ offers. Its tools do not stay in the image.
FROM build AS docs
COPY requirements/docs.txt requirements/
RUN python3 -m venv /opt/docs \
 && /opt/docs/bin/python -m pip install --no-compile --require-hashes --only-binary :all: -r requirements/docs.txt \
 && /opt/docs/bin/python -m pip install --no-deps --no-build-isolation --editable .
COPY docs docs
COPY CHANGELOG.md CONTRIBUTING.md ./
RUN tools/container-entry /opt/docs/bin/python -m sphinx --fail-on-warning --quiet --doctree-dir /tmp/docs/doctrees docs /tmp/docs/site \
 && mv /tmp/docs/site assets/ \
 && /opt/docs/bin/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir /tmp . \
 && name=$(basename /tmp/*.whl) \
 && mv "/tmp/$name" assets/site/wheel/ \
 && sed --in-place "s|^<p>No wheel.*|<p><a href=\"$name\">$name</a></p>|; /^<code>dist/d" assets/site/wheel/index.html


FROM ${BASE}
COPY --from=build /opt/vibroscope /opt/vibroscope
COPY --from=docs /opt/vibroscope/assets/site /opt/vibroscope/assets/site
WORKDIR /opt/vibroscope

# The one folder that may be written to, if something writable is mounted on it: sweeps, shared by replicas.
RUN install --directory --owner=10001 --group=10001 cache/studies

# Everything else belongs to root and the process is nobody: the engine takes its own copy of the kernels' machine code
# into the temporary folder, since Numba passes over a cache it cannot write to.
ENV PATH=/opt/vibroscope/.venv/bin:$PATH \
    VIBROSCOPE_CACHE_DIR=/opt/vibroscope/cache \
    VIBROSCOPE_ADDRESS=0.0.0.0 \
    HOME=/tmp \
    PYTHONDONTWRITEBYTECODE=1 \
    PYTHONUNBUFFERED=1
USER 10001:10001
EXPOSE 5006

# /liveness answers without building a page.
HEALTHCHECK --interval=30s --timeout=5s --start-period=30s --retries=3 \
    CMD ["python3", "-c", "import os, urllib.request as u; u.urlopen(f'http://127.0.0.1:{os.environ.get(\"VIBROSCOPE_PORT\") or 5006}/liveness', timeout=4)"]

# One process: a stop signal lets what is under way end, then it exits with 0. For more users run more containers behind a
# sticky proxy (compose.yaml). `vibroscope serve --help` lists the settings that -e takes.
ENTRYPOINT ["/opt/vibroscope/tools/container-entry"]
CMD ["vibroscope", "serve"]
