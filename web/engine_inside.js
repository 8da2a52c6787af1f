// Inside of emscripten's module: the standard streams as Module.streams has them, files of a browser mapped into memory, and memory that runs out.
Module["preRun"] = [].concat(Module["preRun"] || [], () => {
  const streams = Module["streams"];
  const device = (number, terminal) => ({
    open(stream) {
      stream.seekable = false;
      stream.tty = terminal(stream);
    },
    close() {},
    fsync() {},
    read(stream, buffer, offset, length) {
      return streams.read(buffer, offset, length);
    },
    write(stream, buffer, offset, length) {
      return streams.write(number, buffer.slice(offset, offset + length));
    },
  });
  const isTerminal = (number) => (streams.isTerminal(number) ? { ops: {} } : undefined);
  FS.registerDevice(FS.makedev(5, 0), device(1, (stream) => isTerminal(stream.flags & 3 ? 1 : 0))); // /dev/stdin and /dev/stdout
  FS.registerDevice(FS.makedev(6, 0), device(2, () => isTerminal(2))); // /dev/stderr
  const cut = FS.ftruncate; // in node by a file's name, which a temporary file has no more
  FS.ftruncate = (descriptor, length) => {
    const { nfd } = FS.getStream(descriptor) ?? {};
    if (nfd === undefined) return cut(descriptor, length);
    try {
      fs.ftruncateSync(nfd, length);
    } catch (error) {
      throw new FS.ErrnoError(NODEFS.convertNodeCode(error));
    }
  };
  const noMemory = 48;
  let kept; // the first: each pass over a file maps it, and a browser reads it more slowly than the pass
  WORKERFS.stream_ops.mmap = (stream, address, length, position) => {
    const asked = JSON.stringify([stream.path, length, position]);
    if (kept && kept.asked === asked) return { ptr: kept.place, allocated: false };
    const place = mmapAlloc(length);
    if (!place) throw new FS.ErrnoError(noMemory);
    const piece = 1 << 26; // the browser holds each once more
    for (let at = 0; at < length; at += piece) WORKERFS.stream_ops.read(stream, HEAP8, place + at, Math.min(piece, length - at), position + at);
    if (!kept) kept = { asked, place };
    return { ptr: place, allocated: kept.place !== place }; // what is allocated is freed when it is unmapped
  };
  const expand = MEMFS.expandFileStorage; // files in memory are the browser's: an error of the system, which the command puts into words
  MEMFS.expandFileStorage = (node, size) => {
    try {
      return expand(node, size);
    } catch (error) {
      if (error instanceof RangeError) throw new FS.ErrnoError(noMemory);
      throw error;
    }
  };
});
