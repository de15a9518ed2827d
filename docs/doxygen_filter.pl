# Makes the project's plain comments Doxygen's, line by line, so that line
# numbers stay: comments before a declaration become ///, the comment that opens
# a header becomes the description of the file, comments behind a member ///<.
# Text is shown as it is written: what Doxygen would take for a command or a tag
# is escaped.
use strict;
use warnings;

local $/;
my $text = <>;
if ($ARGV =~ /\.md$/ || $text !~ /#ifndef \w+_H_/) {
  print $text;
  exit;
}

sub escaped {
  my ($comment) = @_;
  $comment =~ s/([\\@<>#%&])/\\$1/g;
  return $comment;
}

my $in_opening = 1;
my @out;
for my $line (split /\n/, $text, -1) {
  $in_opening = 0 if $line =~ /^#ifndef/;
  if ($line =~ m{^(\s*)//(.*)$}) {
    my ($indent, $comment) = ($1, escaped($2));
    # An indented line is an equation, a table or an example.
    $comment = ' \htmlonly <br> \endhtmlonly ' . $comment if $comment =~ /^ {3,}\S/;
    push @out, $in_opening && !@out ? "$indent/// \@file \\ilinebr \@brief$comment" : "$indent///$comment";
  } elsif ($line =~ m{^(.*\S)\s+// (.*)$} && $line !~ /^\s*#/ && $line !~ /"[^"]*\/\//) {
    push @out, "$1  ///< " . escaped($2);
  } else {
    push @out, $line;
  }
}
print join("\n", @out);
