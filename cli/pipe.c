/* Programs fed through a pipe. */
#include "cli/pipe.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* In the child: connects the three streams and becomes the program. Reports an errno through `report` if it
 * cannot. */
static void become(const char *const *argv, int input, int answer, int complaints, int report) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, NULL);
  signal(SIGPIPE, SIG_DFL);
  if (dup2(input, STDIN_FILENO) >= 0 && dup2(answer, STDOUT_FILENO) >= 0 &&
      dup2(complaints, STDERR_FILENO) >= 0)
    execvp(argv[0], (char *const *)argv);
  int reason = errno;
  ssize_t done = write(report, &reason, sizeof reason);
  _exit(done == (ssize_t)sizeof reason ? 127 : 126);
}

/* A pipe whose ends do not leak into other programs. */
static bool make_pipe(int ends[2]) {
  if (pipe(ends) != 0) return false;
  fcntl(ends[0], F_SETFD, FD_CLOEXEC);
  fcntl(ends[1], F_SETFD, FD_CLOEXEC);
  return true;
}

/* Closes descriptors that are open. */
static void close_all(const int *fds, int count) {
  for (int i = 0; i < count; i++)
    if (fds[i] >= 0) close(fds[i]);
}

/* Starts the child; 0, or the errno that explains why not. */
static int start(cli_pipe *p, const char *const *argv, const char *answer) {
  int fds[5] = {-1, -1, -1, -1, -1}, reason = 0; /* input 0 1, report 2 3, answer 4 */
  fds[4] = open(answer ? answer : "/dev/null", O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fds[4] < 0 || !make_pipe(fds) || !make_pipe(fds + 2)) reason = errno;
  if (!reason) {
    p->pid = fork();
    if (p->pid < 0) reason = errno;
    if (p->pid == 0) become(argv, fds[0], fds[4], fileno(p->complaints), fds[3]);
  }
  if (reason) {
    close_all(fds, 5);
    return reason;
  }
  close(fds[0]);
  close(fds[3]);
  close(fds[4]);
  ssize_t got = read(fds[2], &reason, sizeof reason);
  close(fds[2]);
  if (got == (ssize_t)sizeof reason) { /* the program did not start */
    close(fds[1]);
    waitpid(p->pid, NULL, 0);
    return reason;
  }
  p->to = fds[1];
  return 0;
}

/* Opens the streams, starts the program. */
hb_status cli_pipe_open(cli_pipe *p, const char *const *argv, const char *package, const char *answer,
                        hb_error *err) {
  *p = (cli_pipe){.to = -1, .program = argv[0]};
  p->complaints = tmpfile();
  if (!p->complaints)
    return hb_fail(err, HB_ERR_IO, "no temporary file for %s: %s", argv[0], strerror(errno));
  fcntl(fileno(p->complaints), F_SETFD, FD_CLOEXEC);
  struct sigaction ignore = {.sa_handler = SIG_IGN};
  sigemptyset(&ignore.sa_mask);
  sigaction(SIGPIPE, &ignore, &p->old_broken);
  int reason = start(p, argv, answer);
  if (!reason) return HB_OK;
  sigaction(SIGPIPE, &p->old_broken, NULL);
  fclose(p->complaints);
  p->complaints = NULL;
  if (reason == ENOENT)
    return hb_fail(err, HB_ERR_MISSING,
                   "the program %s is not installed; on Debian and Ubuntu: apt-get install %s", argv[0],
                   package);
  return hb_fail(err, HB_ERR_IO, "the program %s cannot be started: %s", argv[0], strerror(reason));
}

/* First line of what the program complained about; an empty text if nothing. */
static void first_complaint(cli_pipe *p, char *text, size_t size) {
  text[0] = 0;
  rewind(p->complaints);
  while (fgets(text, (int)size, p->complaints)) {
    size_t length = strcspn(text, "\r\n");
    text[length] = 0;
    if (text[strspn(text, " \t^")]) return;
  }
  text[0] = 0;
}

/* Writes all of it, however small the portions. */
hb_status cli_pipe_write(cli_pipe *p, const void *bytes, size_t count, hb_error *err) {
  const char *at = bytes;
  while (count > 0) {
    ssize_t done = p->to >= 0 ? write(p->to, at, count) : -1;
    if (done < 0 && p->to >= 0 && errno == EINTR) continue;
    if (done < 0) {
      char text[400];
      first_complaint(p, text, sizeof text);
      return hb_fail(err, HB_ERR_IO, "%s stopped reading%s%s", p->program, text[0] ? ": " : "", text);
    }
    at += done;
    count -= (size_t)done;
  }
  return HB_OK;
}

/* Closes the input first: that tells the program that it has everything. */
hb_status cli_pipe_close(cli_pipe *p, hb_error *err) {
  if (!p->complaints) return HB_OK;
  if (p->to >= 0) close(p->to);
  p->to = -1;
  int how = 0;
  while (waitpid(p->pid, &how, 0) < 0 && errno == EINTR) {
  }
  sigaction(SIGPIPE, &p->old_broken, NULL);
  char text[400];
  first_complaint(p, text, sizeof text);
  fclose(p->complaints);
  p->complaints = NULL;
  if (WIFEXITED(how) && WEXITSTATUS(how) == 0) return HB_OK;
  if (WIFSIGNALED(how))
    return hb_fail(err, HB_ERR_IO, "%s was ended by signal %d", p->program, WTERMSIG(how));
  return hb_fail(err, HB_ERR_IO, "%s failed with status %d%s%s", p->program, WEXITSTATUS(how),
                 text[0] ? ": " : "", text);
}
