// Inside of emscripten's module: the standard streams as Module.streams has them, and files of a browser mapped into memory.
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
  WORKERFS.stream_ops.mmap = (stream, length, position) => {
    const place = mmapAlloc(length);
    if (!place) throw new FS.ErrnoError(48); // no memory
    WORKERFS.stream_ops.read(stream, HEAP8, place, length, position);
    return { ptr: place, allocated: true };
  };
});
