# The program and its tools, as tools/setup and tools/build make them on Debian 12.
#   docker build -t musclebench .
#   docker run --rm musclebench list
#   docker run --rm -v "$PWD/results:/musclebench/reports/out" --entrypoint tools/paper musclebench \
#       --musclebench build/release/bench/musclebench
FROM debian:12 AS build
WORKDIR /musclebench
# By themselves, so that packages are installed again only when their list changes.
COPY tools/setup tools/packages.txt tools/
RUN tools/setup pybind11-dev
COPY . .
RUN tools/build release

FROM debian:12
WORKDIR /musclebench
COPY tools/setup tools/packages.txt tools/
# The tools' packages, npm for pages, and the libraries that the program is linked with.
RUN tools/setup --python nodejs npm libassimp5 libfcl0.7 libfmt9 libgomp1 libhwy1 libssl3 libtomlplusplus3 libzstd1
COPY . .
COPY --from=build /musclebench/build/release/bench/musclebench build/release/bench/musclebench
COPY --from=build /musclebench/build/release/python build/release/python
ENTRYPOINT ["build/release/bench/musclebench"]
